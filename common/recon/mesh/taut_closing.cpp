#include <recon/mesh/taut_closing.h>

#include <recon/disjoint_sets.h>
#include <recon/mesh/mismatch.h>
#include <recon/mesh/triangle_cuts.h>
#include <recon/parallel.h>
#include <recon/search/nearest_samples.h>
#include <recon/search/neighbours.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <Eigen/SparseLU>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

namespace recon
{
namespace
{

using Corners = std::array<int, 3>;

/// What is cut keeps this share of its way, again and again, and below the second one stays.
constexpr double kept_way = 0.75, least_way = 0.1;
/// Rounds in which vertices are held back [count]; in trials the last cut was clear after 7.
constexpr int most_rounds = 30;

std::vector<char> find_bare_vertices(const TriangleMesh& mesh, const Points& samples, int threads)
{
    const NearestSamples nearest = find_nearest_samples(mesh.vertices, samples, threads);
    const NeighbourSearch search(samples);
    std::vector<char> result(mesh.vertices.size(), 0);
    parallel_for(result.size(), threads, {},
                 [&](std::size_t v)
                 {
                     if (nearest.squared[v] > 0) // most are samples
                         result[v] = std::sqrt(nearest.squared[v]) >
                                     bare_beyond * measure_spacing_at(samples[nearest.sample[v]], search);
                 });
    return result;
}

/// Takes back what hangs on no held vertex: a body without samples.
void hold_parts_without_rim(const TriangleMesh& mesh, std::vector<char>& is_bare)
{
    DisjointSets parts(is_bare.size());
    for (const Corners& t : mesh.triangles)
        for (int k = 0; k < 3; ++k)
            if (is_bare[t[k]] && is_bare[t[(k + 1) % 3]])
                parts.join(t[k], t[(k + 1) % 3]);
    std::vector<char> has_rim(is_bare.size(), 0);
    for (const Corners& t : mesh.triangles)
        for (int k = 0; k < 3; ++k)
            if (is_bare[t[k]] && !is_bare[t[(k + 1) % 3]])
                has_rim[std::size_t(parts.find(t[k]))] = 1;
    for (std::size_t v = 0; v < is_bare.size(); ++v)
        is_bare[v] = is_bare[v] && has_rim[std::size_t(parts.find(int(v)))];
}

/// Tangent of half the angle at `a` between the directions to `b` and `c`, kept off 0 and infinity.
double half_tangent(const Point& a, const Point& b, const Point& c)
{
    constexpr double least = 1e-6;
    const Vector u = b - a, v = c - a;
    const double length = std::sqrt(u.squaredNorm() * v.squaredNorm());
    return length > 0 ? std::max(u.cross(v).norm() / std::max(length + u.dot(v), least * length), least) : least;
}

/// What a triangle adds to the mean value weights (Floater 2003) of two of its corners at the third: of the next corner
/// at corner k to entry 2 k, of the previous one to entry 2 k + 1.
std::array<double, 6> list_mean_value_weights(const TriangleMesh& mesh, const Corners& t)
{
    std::array<double, 3> side, tangent;
    for (int k = 0; k < 3; ++k)
    {
        const Point &a = mesh.vertices[t[k]], &b = mesh.vertices[t[(k + 1) % 3]], &c = mesh.vertices[t[(k + 2) % 3]];
        side[k] = (b - a).norm();
        tangent[k] = half_tangent(a, b, c);
    }
    const double shortest = std::max(1e-3 * std::max({side[0], side[1], side[2]}), 1e-300);
    std::array<double, 6> result;
    for (int k = 0; k < 3; ++k)
    {
        result[2 * k] = tangent[k] / std::max(side[k], shortest);
        result[2 * k + 1] = tangent[k] / std::max(side[(k + 2) % 3], shortest);
    }
    return result;
}

/// Moves each free vertex to the mean of its neighbours, by weights in `mesh`, of which a flat part stays as it is.
/// \pre each hangs on a vertex that is not free.
void draw_taut(Points& places, const TriangleMesh& mesh, const std::vector<char>& is_free)
{
    std::vector<int> unknown(places.size(), -1), vertices;
    for (std::size_t v = 0; v < places.size(); ++v)
        if (is_free[v])
        {
            unknown[v] = int(vertices.size());
            vertices.push_back(int(v));
        }
    if (vertices.empty())
        return;
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(Eigen::Index(vertices.size()), 3);
    const auto attract = [&](int from, int to, double weight)
    {
        entries.emplace_back(unknown[from], unknown[from], weight);
        if (unknown[to] >= 0)
            entries.emplace_back(unknown[from], unknown[to], -weight);
        else
            right.row(unknown[from]) += weight * places[to].transpose();
    };
    for (const Corners& t : mesh.triangles)
    {
        if (!is_free[t[0]] && !is_free[t[1]] && !is_free[t[2]])
            continue;
        const std::array<double, 6> weights = list_mean_value_weights(mesh, t);
        for (int k = 0; k < 3; ++k)
            if (is_free[t[k]])
            {
                attract(t[k], t[(k + 1) % 3], weights[2 * k]);
                attract(t[k], t[(k + 2) % 3], weights[2 * k + 1]);
            }
    }
    Eigen::SparseMatrix<double> laplacian(right.rows(), right.rows());
    laplacian.setFromTriplets(entries.begin(), entries.end());
    Eigen::SparseLU<Eigen::SparseMatrix<double>> factors;
    factors.compute(laplacian);
    if (factors.info() != Eigen::Success)
        return;
    const Eigen::MatrixXd solution = factors.solve(right);
    for (std::size_t i = 0; i < vertices.size(); ++i)
        places[vertices[i]] = solution.row(Eigen::Index(i)).transpose();
}

/// A mesh whose free vertices are drawn taut; those that are then cut are held back.
class TautMesh
{
public:
    TautMesh(const TriangleMesh& mesh, std::vector<char> is_free, int threads)
        : places(mesh.vertices), mesh_(mesh), cuts_(mesh, is_free, threads), cut_before_(cuts_.list(mesh.vertices)),
          way_(mesh.vertices.size(), Vector::Zero()), share_(is_free.begin(), is_free.end()),
          is_free_(std::move(is_free))
    {
    }

    /// \returns whether triangles cut each other that did not; then the vertices of both are held nearer to where they
    /// were.
    bool draw_and_hold_back()
    {
        draw_taut(places, mesh_, is_free_);
        const std::vector<std::pair<int, int>> cut = cuts_.list(places);
        std::vector<std::pair<int, int>> added;
        std::set_difference(cut.begin(), cut.end(), cut_before_.begin(), cut_before_.end(), std::back_inserter(added));
        std::vector<char> is_cut(places.size(), 0);
        for (const auto& [a, b] : added)
            for (const int t : {a, b})
                for (const int v : mesh_.triangles[t])
                    is_cut[v] = 1;
        for (std::size_t v = 0; v < places.size(); ++v)
            if (is_cut[v] && share_[v] > 0)
                hold_back(v);
        return !added.empty();
    }

    Points places;

private:
    void hold_back(std::size_t v)
    {
        if (is_free_[v])
            way_[v] = places[v] - mesh_.vertices[v];
        is_free_[v] = 0;
        share_[v] *= kept_way;
        if (share_[v] < least_way)
            share_[v] = 0;
        places[v] = mesh_.vertices[v] + share_[v] * way_[v];
    }

    const TriangleMesh& mesh_;
    TriangleCuts cuts_;
    std::vector<std::pair<int, int>> cut_before_;
    Vectors way_;               ///< Per vertex: to where it was taut when it was first held back.
    std::vector<double> share_; ///< Per vertex: of that way.
    std::vector<char> is_free_;
};

} // namespace

int draw_bare_faces_taut(TriangleMesh& mesh, const Points& samples, int threads)
{
    if (samples.empty())
        return 0;
    std::vector<char> is_free = find_bare_vertices(mesh, samples, threads);
    hold_parts_without_rim(mesh, is_free);
    if (std::count(is_free.begin(), is_free.end(), 1) == 0)
        return 0;
    TautMesh taut(mesh, std::move(is_free), threads);
    for (int round = 0; taut.draw_and_hold_back(); ++round)
        if (round == most_rounds)
            return 0;
    int moved = 0;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
        moved += taut.places[v] != mesh.vertices[v];
    mesh.vertices = std::move(taut.places);
    return moved;
}

} // namespace recon
