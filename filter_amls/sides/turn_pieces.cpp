#include "turn_pieces.h"

#include <recon/disjoint_sets.h>
#include <recon/search/block_search.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

/// What hangs together in an open cloud.
struct Piece
{
    double area = 0;
    Vector normal = Vector::Zero(); ///< Sums, times area.
    Point moment = Point::Zero();
    Eigen::Matrix3d volume = Eigen::Matrix3d::Zero(); ///< About the origin.
    Box box;

    /// The volume that it encloses, measured along each of three axes: the same for what is closed, none along a tube.
    Vector enclosed() const
    {
        const Eigen::Matrix3d about_mean = volume - normal * (moment / area).transpose();
        return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(about_mean + about_mean.transpose()).eigenvalues() / 2;
    }
    bool is_closed() const
    {
        constexpr double cancelled = 0.2, alike = 0.4; // what is left of the sum of normals, and the least of the mean
        const Vector along = enclosed();
        return normal.norm() < cancelled * area && (along / along.mean()).minCoeff() > alike;
    }
    bool has_within(const Piece& o) const
    {
        return (box.minimum.array() <= o.box.minimum.array()).all() &&
               (box.maximum.array() >= o.box.maximum.array()).all();
    }
};

/// How far what is open faces the closed pieces, seen from their points [-1..1]. 0 if it is all one or the other.
double measure_facing(const Points& points, const std::vector<double>& spacing, const std::vector<char>& is_closed,
                      const Vectors& normals)
{
    std::vector<int> open, closed;
    for (int v = 0; v < int(points.size()); ++v)
        (is_closed[v] ? closed : open).push_back(v);
    if (open.empty() || closed.empty())
        return 0;
    const BlockSearch search(points_at(open, points));
    double facing = 0, all = 0;
    for (const int v : closed)
    {
        const int nearest = open[std::size_t(search.nearest(points[v]))];
        const double area = spacing[v] * spacing[v];
        facing += area * normals[nearest].dot((points[v] - points[nearest]).normalized());
        all += area;
    }
    return facing / all;
}

/// The volume that what is open encloses, beside the most that it could [-1..1]: of a flat sheet hardly any.
double measure_fullness(const Points& points, const std::vector<double>& spacing, const std::vector<char>& is_closed,
                        const Vectors& normals)
{
    const double open = double(std::count(is_closed.begin(), is_closed.end(), 0));
    Vector mean = Vector::Zero();
    for (std::size_t v = 0; v < points.size(); ++v)
        if (!is_closed[v])
            mean += points[v] / open;
    double volume = 0, all = 0;
    for (std::size_t v = 0; v < points.size(); ++v)
        if (!is_closed[v])
        {
            const double area = spacing[v] * spacing[v];
            volume += area * normals[v].dot(points[v] - mean);
            all += area * (points[v] - mean).norm();
        }
    return all > 0 ? volume / all : 0;
}

} // namespace

std::vector<char> turn_closed_pieces(const Triangulation& t, const Points& points, const std::vector<double>& spacing,
                                     Vectors& normals)
{
    constexpr double joined = 3; // spacings
    const int n = int(points.size());
    DisjointSets sets(points.size());
    for (int c = 0; c < t.finite_cells; ++c)
    {
        const auto& v = t.cells[c].vertices;
        for (int i = 0; i < 4; ++i)
            for (int j = i + 1; j < 4; ++j)
                if (v[i] < n && v[j] < n &&
                    (points[v[i]] - points[v[j]]).norm() < joined / 2 * (spacing[v[i]] + spacing[v[j]]))
                    sets.join(v[i], v[j]);
    }
    std::vector<Piece> pieces(points.size()); // at their representatives
    double all = 0;
    for (int v = 0; v < n; ++v)
    {
        Piece& piece = pieces[sets.find(v)];
        const double area = spacing[v] * spacing[v];
        piece.area += area;
        piece.normal += area * normals[v];
        piece.moment += area * points[v];
        piece.volume += area * normals[v] * points[v].transpose();
        piece.box.minimum = piece.box.minimum.cwiseMin(points[v]);
        piece.box.maximum = piece.box.maximum.cwiseMax(points[v]);
        all += area;
    }
    std::vector<int> closed;
    for (int k = 0; k < n; ++k)
        if (pieces[k].area > 0 && pieces[k].area < all / 2 && pieces[k].is_closed())
            closed.push_back(k);
    std::vector<char> is_closed(points.size(), 0), is_inward(points.size(), 0);
    for (const int k : closed)
    {
        is_closed[k] = std::none_of(closed.begin(), closed.end(),
                                    [&](int o) { return o != k && pieces[o].has_within(pieces[k]); });
        is_inward[k] = is_closed[k] && pieces[k].enclosed().sum() < 0;
    }
    for (int v = 0; v < n; ++v)
    {
        const int k = sets.find(v);
        is_closed[v] = is_closed[k];
        if (is_inward[k])
            normals[v] = -normals[v];
    }
    return is_closed;
}

void turn_outward(const Points& points, const std::vector<double>& spacing, bool is_open,
                  const std::vector<char>& is_closed, Vectors& normals)
{
    constexpr double flat = 0.1, clearly = 0.2;
    constexpr std::size_t few = 50; // balls of fewer hardly tell the sides
    const double fullness = measure_fullness(points, spacing, is_closed, normals);
    if (!is_open && points.size() >= few && fullness > -flat)
        return;
    const double facing = std::abs(fullness) < flat ? measure_facing(points, spacing, is_closed, normals) : 0;
    if ((std::abs(facing) > clearly ? facing : fullness) < 0)
        turn_over(normals, is_closed);
}

void turn_over(Vectors& normals, const std::vector<char>& stays)
{
    for (std::size_t i = 0; i < normals.size(); ++i)
        if (!stays[i])
            normals[i] = -normals[i];
}

} // namespace recon
