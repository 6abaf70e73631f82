#include "normals_near_crust.h"

#include <recon/median.h>
#include <recon/mesh/triangle_tree.h>
#include <recon/parallel.h>
#include <recon/search/block_search.h>
#include <recon/search/nearest_samples.h>
#include <recon/search/neighbours.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace recon
{
namespace
{

/// The surface's normal stays within `agreeing` of that of an exact crust, and more where that is rough [radians per
/// spacing]. Beyond `tilted` roughness does not explain how far they part.
constexpr double agreeing = 0.1, agreeing_roughness = 5, tilted_roughness = 100, most_agreeing = 1;
/// A surface that passes an exact point, or one of those around, at more than this rounds a detail [spacings]; more
/// where the crust is rough.
constexpr double passes_by = 0.02, passes_by_roughness = 5;
/// Of a crust through samples, the surface's normal stays within this [radians]. The crust's are as good there, but
/// where the surface is smooth.
constexpr double agreeing_beside = 0.4;
/// Samples whose normals are within this [radians] of those of so many around lie where the surface is plain; what
/// agrees with them there need not look for its nearest place. Fewer are all on one side of a thin wall.
constexpr double plain_within = 0.5;
constexpr int around_plain = 20;

/// Faces with a side longer than so many times the median of those at a corner close holes: at the rim these have
/// little say.
constexpr double longest_side = 2.5;
/// Longer than so many times the median sides at all its corners a face is a lid, beside which only opposite normals
/// are wrong.
constexpr double side_of_lid = 2;

constexpr int around = 7; ///< A sample and the six nearest others [count].

double angle_between(const Vector& a, const Vector& b)
{
    return std::acos(std::clamp(a.dot(b), -1.0, 1.0));
}

/// Whether the crust leaves each sample out. \param farthest from a vertex [mean distance of the six nearest samples].
std::vector<char> find_left_out(const CrustNormals& crust, double farthest, const Points& samples,
                                const BlockSearch& search, int threads)
{
    std::vector<char> is_left_out(samples.size());
    if (!std::isfinite(farthest))
        return is_left_out;
    parallel_for(
        samples.size(), threads, {},
        [&](std::size_t i) { is_left_out[i] = crust.distances[i] > farthest * measure_spacing_at(samples[i], search); },
        1024);
    return is_left_out;
}

/// How closely a surface passes by exact samples.
class Passing
{
public:
    /// \param passed_by by how much it passes each sample [length].
    Passing(const Points& samples, const BlockSearch& search, std::vector<double> passed_by)
        : samples_(samples), search_(search), passed_by_(std::move(passed_by))
    {
    }

    /// The most by which it passes the sample or one of the six nearest others [their mean distance].
    double at(int sample) const
    {
        std::array<int, around> indices;
        std::array<double, around> squared;
        const int count = search_.nearest(samples_[std::size_t(sample)], around, indices.data(), squared.data());
        double spacing = 0, passed = 0;
        for (int k = 0; k < count; ++k)
        {
            spacing += std::sqrt(squared[std::size_t(k)]) / (count - 1);
            passed = std::max(passed, passed_by_[std::size_t(indices[std::size_t(k)])]);
        }
        return passed / spacing;
    }

private:
    const Points& samples_;
    const BlockSearch& search_;
    std::vector<double> passed_by_;
};

/// Replaces normals. \param better_at from an index to another normal, zero if there is none.
template <class BetterAt>
int replace(Vectors& normals, int threads, const Progress& progress, const BetterAt& better_at)
{
    std::vector<char> is_replaced(normals.size());
    parallel_for(
        normals.size(), threads, progress,
        [&](std::size_t i)
        {
            const Vector better = better_at(i);
            if (better.squaredNorm() == 0)
                return;
            normals[i] = better;
            is_replaced[i] = 1;
        },
        1024);
    return int(std::count(is_replaced.begin(), is_replaced.end(), 1));
}

/// Whether each sample and those around have about the same normal.
std::vector<char> find_plain_samples(const Points& samples, const Vectors& normals, const BlockSearch& search,
                                     int threads)
{
    std::vector<char> is_plain(samples.size());
    parallel_for(samples.size(), threads, {},
                 [&](std::size_t i)
                 {
                     std::array<int, around_plain> indices;
                     std::array<double, around_plain> squared;
                     const int count = search.nearest(samples[i], around_plain, indices.data(), squared.data());
                     is_plain[i] =
                         std::all_of(indices.begin(), indices.begin() + count,
                                     [&](int other)
                                     { return normals[std::size_t(other)].dot(normals[i]) > std::cos(plain_within); });
                 });
    return is_plain;
}

/// Normals of a closed mesh anywhere on it.
class MeshNormals
{
public:
    explicit MeshNormals(const TriangleMesh& mesh) : mesh_(mesh), sides_(mesh.vertices.size())
    {
        std::vector<std::vector<double>> sides(mesh.vertices.size());
        for (const auto& t : mesh.triangles)
            for (int k = 0; k < 3; ++k)
                sides[std::size_t(t[k])].push_back(side(t, k));
        for (std::size_t v = 0; v < sides.size(); ++v)
            sides_[v] = median(std::move(sides[v]));
        normals_ = sum_corner_normals(
            mesh, [&](const Triangle& t, int k) -> Vector { return weight_at(t, k) * cross(t).normalized(); });
    }

    /// Linear between those of the corners. \param place on the triangle.
    Vector at(const Point& place, int triangle) const
    {
        const auto& t = mesh_.triangles[std::size_t(triangle)];
        Vector sum = Vector::Zero();
        for (int k = 0; k < 3; ++k)
            sum += (corner(t, k + 1) - place).cross(corner(t, k + 2) - place).norm() * normals_[std::size_t(t[k])];
        return sum.normalized();
    }

    bool is_lid(int triangle) const
    {
        const auto& t = mesh_.triangles[std::size_t(triangle)];
        const double usual =
            std::max({sides_[std::size_t(t[0])], sides_[std::size_t(t[1])], sides_[std::size_t(t[2])]});
        return longest(t) > side_of_lid * usual;
    }

private:
    using Triangle = std::array<int, 3>;

    const Point& corner(const Triangle& t, int k) const { return mesh_.vertices[std::size_t(t[std::size_t(k % 3)])]; }
    double side(const Triangle& t, int k) const { return (corner(t, k + 1) - corner(t, k)).norm(); }
    double longest(const Triangle& t) const { return std::max({side(t, 0), side(t, 1), side(t, 2)}); }
    Vector cross(const Triangle& t) const { return (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)); }

    /// The angle, less of long faces.
    double weight_at(const Triangle& t, int k) const
    {
        const double angle = angle_between((corner(t, k + 1) - corner(t, k)).normalized(),
                                           (corner(t, k + 2) - corner(t, k)).normalized());
        const double length = longest(t), bearable = longest_side * sides_[std::size_t(t[std::size_t(k)])];
        return length > bearable ? angle * std::pow(bearable / length, 4) : angle;
    }

    const TriangleMesh& mesh_;
    std::vector<double> sides_; ///< Median at each vertex [length].
    Vectors normals_;           ///< At each vertex.
};

} // namespace

int take_normals_of_exact_crust(const LabelledSamples& found, const CrustNormals& crust, const Points& points,
                                const AmlsProjection& surface, double farthest, int threads, Vectors& normals,
                                const Progress& progress)
{
    const BlockSearch search(found.samples, threads);
    const std::vector<char> is_left_out = find_left_out(crust, farthest, found.samples, search, threads);
    const Points unit = found.frame.to_unit(points);
    const NearestSamples nearest =
        find_nearest_samples(unit, found.samples, search, threads, progress.part(0, 0.5, "normals"));
    std::vector<double> passed_by(found.samples.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        if (nearest.squared[i] == 0) // others were left out
            passed_by[std::size_t(nearest.sample[i])] = (surface.points[i] - points[i]).norm() / found.frame.scale();
    const Passing passing(found.samples, search, std::move(passed_by));
    const double least = std::min(agreeing + agreeing_roughness * found.least_roughness, most_agreeing),
                 most = std::min(agreeing + tilted_roughness * found.least_roughness, most_agreeing),
                 rounded = passes_by + passes_by_roughness * found.least_roughness;
    return replace(normals, threads, progress.part(0.5, 1, "normals"),
                   [&](std::size_t i) -> Vector
                   {
                       const auto sample = std::size_t(nearest.sample[i]);
                       if (is_left_out[sample])
                           return Vector::Zero();
                       const Vector& normal = crust.normals[sample];
                       const double angle = angle_between(normal, normals[i]);
                       const bool is_better =
                           angle > most || (angle >= least && passing.at(nearest.sample[i]) > rounded);
                       return is_better ? normal : Vector::Zero();
                   });
}

int take_normals_beside_crust(const LabelledSamples& found, const CrustNormals& crust, const Points& points,
                              double farthest, int threads, Vectors& normals, const Progress& progress)
{
    const BlockSearch search(found.samples, threads);
    const std::vector<char> is_left_out = find_left_out(crust, farthest, found.samples, search, threads);
    const std::vector<char> is_plain = find_plain_samples(found.samples, crust.normals, search, threads);
    const Points unit = found.frame.to_unit(points);
    const NearestSamples nearest =
        find_nearest_samples(unit, found.samples, search, threads, progress.part(0, 0.3, "normals"));
    const TriangleTree tree(crust.crust.vertices, crust.crust.triangles);
    const MeshNormals crust_normals(crust.crust);
    const double most_cosine = std::cos(agreeing_beside);
    return replace(
        normals, threads, progress.part(0.3, 1, "normals"),
        [&](std::size_t i) -> Vector
        {
            const auto sample = std::size_t(nearest.sample[i]);
            if (is_left_out[sample] || (is_plain[sample] && crust.normals[sample].dot(normals[i]) > most_cosine))
                return Vector::Zero();
            const TriangleTree::Nearest on_crust = tree.nearest(unit[i]);
            const Vector normal = crust_normals.at(on_crust.place, on_crust.triangle);
            const double cosine = normal.dot(normals[i]);
            return cosine < 0 || (cosine < most_cosine && !crust_normals.is_lid(on_crust.triangle)) ? normal
                                                                                                    : Vector::Zero();
        });
}

} // namespace recon
