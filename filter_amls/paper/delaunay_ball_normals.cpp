#include "delaunay_ball_normals.h"

#include <recon/disjoint_sets.h>
#include <recon/errors.h>
#include <recon/noise/noise.h>
#include <recon/parallel.h>
#include <recon/search/neighbours.h>
#include <recon/search/spatial_order.h>
#include <recon/triangulation/delaunay.h>
#include <recon/triangulation/polar_balls.h>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

constexpr double paper_ratio = 2.5;
constexpr int paper_neighbours = 5;
/// Balls between noisy points reach farther than those between exact ones, or, where there is more noise than spacing,
/// as far as the noise.
constexpr double automatic_sigmas = 4;
constexpr double deep_cosine = 0.7071; // intersection angle above 3/4 pi
constexpr double widest_pole = 1;      // diagonals

void check(const DelaunayBallOptions& options)
{
    if (!(options.big_ball_ratio >= 0) || !std::isfinite(options.big_ball_ratio))
        throw InvalidInput("The ratio of a big ball must be 0 (automatic) or a positive number; the paper uses 2.5.");
    if (options.neighbours < 0)
        throw InvalidInput("The number of neighbours must be 0 (automatic) or more.");
    if (options.normal_spread < 1)
        throw InvalidInput("Normals must spread over at least 1 point.");
}

/// Radius from which a ball at each point is big.
std::vector<double> find_thresholds(const Points& points, const DelaunayBallOptions& options, int threads,
                                    const Progress& progress)
{
    const double ratio = options.big_ball_ratio > 0 ? options.big_ball_ratio : paper_ratio;
    const int k = std::min(options.neighbours > 0 ? options.neighbours : paper_neighbours, int(points.size()));
    const NeighbourSearch search(points);
    std::vector<double> thresholds(points.size());
    parallel_chunks(points.size(), threads, 1024, progress.part(0, 0.5),
                    [&](std::size_t begin, std::size_t end)
                    {
                        std::vector<int> near(k + 1);
                        std::vector<double> squared(k + 1);
                        for (std::size_t i = begin; i < end; ++i)
                        {
                            const int count = search.nearest(points[i], k + 1, near.data(), squared.data());
                            double sum = 0;
                            for (int j = 1; j < count; ++j)
                                sum += std::sqrt(squared[j]);
                            thresholds[i] = ratio * sum / std::max(1, count - 1);
                        }
                    });
    if (options.big_ball_ratio > 0)
        return thresholds;
    NoiseOptions noise_options;
    noise_options.threads = threads;
    const NoiseEstimate noise = estimate_noise(points, noise_options, progress.part(0.5, 1));
    parallel_for(
        points.size(), threads, {},
        [&](std::size_t i) { thresholds[i] += automatic_sigmas * noise.sigma_at(points[i]); }, 1024);
    return thresholds;
}

/// The Delaunay balls of the points and of a box around them. Points come first.
struct Balls
{
    Triangulation delaunay;
    std::vector<double> radius; ///< Per finite cell, here and below.
    std::vector<char> big;      ///< For one of the points that it touches, or at a corner of the box.
    std::vector<int> biggest;   ///< Per point: its biggest big ball, -1 if it has none.
};

Balls find_balls(const Points& points, const std::vector<double>& threshold, int threads, const Progress& progress)
{
    const int n = int(points.size());
    Points with_box = points;
    append_box_corners(with_box);
    Balls balls;
    balls.delaunay = triangulate_delaunay(with_box, progress, threads);
    const Triangulation& t = balls.delaunay;
    std::vector<double>& radius = balls.radius;
    radius.resize(t.finite_cells);
    balls.big.assign(t.finite_cells, 0);
    balls.biggest.assign(n, -1);
    for (int c = 0; c < t.finite_cells; ++c)
    {
        radius[c] = (t.centres[c] - with_box[t.cells[c].vertices[0]]).norm();
        for (int v : t.cells[c].vertices)
        {
            if (v >= n)
                balls.big[c] = 1;
            else if (radius[c] > threshold[v])
            {
                balls.big[c] = 1;
                if (balls.biggest[v] < 0 || radius[c] > radius[balls.biggest[v]])
                    balls.biggest[v] = c;
            }
        }
    }
    return balls;
}

/// Joins big balls of neighbouring cells that intersect deeply, and the infinite cells as number `finite_cells`: what
/// is outside (Dey and Goswami 2004).
DisjointSets join_deep_balls(const Balls& balls)
{
    const Triangulation& t = balls.delaunay;
    const std::vector<double>& radius = balls.radius;
    const int outside = t.finite_cells;
    DisjointSets parts(std::size_t(outside) + 1);
    for (int c = 0; c < t.finite_cells; ++c)
        for (int o : t.cells[c].neighbours)
        {
            if (!t.is_finite(o))
                parts.join(c, outside);
            else if (o > c && balls.big[c] && balls.big[o])
            {
                const double cosine =
                    (radius[c] * radius[c] + radius[o] * radius[o] - (t.centres[c] - t.centres[o]).squaredNorm()) /
                    (2 * radius[c] * radius[o]);
                if (cosine > deep_cosine)
                    parts.join(c, o);
            }
        }
    return parts;
}

/// Per point that has a biggest ball the biggest big one on its other side, -1 if there is none.
std::vector<int> find_opposite_balls(const Balls& balls, const Points& points, const std::vector<double>& threshold)
{
    const Triangulation& t = balls.delaunay;
    const int n = int(points.size());
    std::vector<int> opposite(n, -1);
    for (int c = 0; c < t.finite_cells; ++c)
        for (int v : t.cells[c].vertices)
            if (v < n && balls.biggest[v] >= 0 && balls.radius[c] > threshold[v] && balls.radius[c] < widest_pole &&
                (t.centres[c] - points[v]).dot(t.centres[balls.biggest[v]] - points[v]) < 0 &&
                (opposite[v] < 0 || balls.radius[c] > balls.radius[opposite[v]]))
                opposite[v] = c;
    return opposite;
}

/// Gives every point without a normal of its own the mean of the nearest that are: every sample must take part in N and
/// W, or only the envelopes of the noise would. \param own points that have one.
void spread_normals(const Points& points, const std::vector<int>& own, int nearest, int threads, Vectors& normals)
{
    std::vector<char> has_own(points.size(), 0);
    for (const int v : own)
        has_own[v] = 1;
    const Points own_points = points_at(own, points);
    const NeighbourSearch search(own_points);
    parallel_chunks(points.size(), threads, 1024, {},
                    [&](std::size_t begin, std::size_t end)
                    {
                        std::vector<int> near(nearest);
                        std::vector<double> squared(nearest);
                        for (std::size_t v = begin; v < end; ++v)
                        {
                            if (has_own[v])
                                continue;
                            const int count = search.nearest(points[v], nearest, near.data(), squared.data());
                            Vector sum = Vector::Zero();
                            for (int k = 0; k < count; ++k)
                                sum += normals[own[near[k]]];
                            normals[v] = sum.norm() > 1e-9 ? sum.normalized() : normals[own[near[0]]];
                        }
                    });
}

} // namespace

DelaunayBallNormals find_delaunay_ball_normals(const Points& input, const DelaunayBallOptions& options,
                                               const Progress& progress)
{
    const ThreadTeam team;
    check(options);
    const int threads = resolve_threads(options.threads);
    check_spans_volume(input);
    const UnitFrame frame(input);
    const SpatialOrder spatial = order_input(input, threads);
    Points points;
    for (int i : spatial.order)
        points.push_back(frame.to_unit(input[i]));
    const int n = int(points.size());
    const std::vector<double> threshold =
        find_thresholds(points, options, threads, progress.part(0, 0.2, "Size of big balls"));
    const Balls balls = find_balls(points, threshold, threads, progress.part(0.2, 0.7, "Delaunay triangulation"));
    progress.part(0.7, 1, "Normals").report(0);

    DelaunayBallNormals result;
    DisjointSets parts = join_deep_balls(balls);
    const int outside = balls.delaunay.finite_cells;
    Vectors normals(n, Vector::Zero());
    std::vector<int> own;
    for (int v = 0; v < n; ++v)
    {
        const int c = balls.biggest[v];
        if (c < 0)
            continue;
        const Point& centre = balls.delaunay.centres[c];
        const double side = parts.find(c) == parts.find(outside) ? 1 : -1;
        const Vector direction = (centre - points[v]) / std::max(balls.radius[c], 1e-300);
        normals[v] = side * direction.normalized();
        own.push_back(v);
        if (balls.radius[c] < widest_pole)
            result.poles.push_back(frame.from_unit(centre));
    }
    if (own.empty())
        throw AlgorithmFailure(
            "No Delaunay ball is big: the noise is as thick as the shape. Lower the ratio of a big ball.");
    result.with_big_ball = int(own.size());
    for (const int c : find_opposite_balls(balls, points, threshold))
        if (c >= 0)
            result.poles.push_back(frame.from_unit(balls.delaunay.centres[c]));
    spread_normals(points, own, options.normal_spread, threads, normals);
    for (const int i : spatial.representative)
        result.normals.push_back(normals[i]);
    return result;
}

} // namespace recon
