#include "delaunay_ball_normals.h"

#include <recon/delaunay.h>
#include <recon/disjoint_sets.h>
#include <recon/errors.h>
#include <recon/neighbours.h>
#include <recon/noise.h>
#include <recon/parallel.h>
#include <recon/spatial_order.h>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

constexpr double paper_ratio = 2.5;
constexpr int paper_neighbours = 5;
constexpr double automatic_sigmas = 4; // balls inside the noise are smaller
constexpr double box_half_width = 2.5; // diagonals
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
std::vector<double> find_thresholds(const Points& points, const DelaunayBallOptions& options, int threads)
{
    const double ratio = options.big_ball_ratio > 0 ? options.big_ball_ratio : paper_ratio;
    const int k = std::min(options.neighbours > 0 ? options.neighbours : paper_neighbours, int(points.size()));
    const NeighbourSearch search(points);
    std::vector<double> thresholds(points.size());
    parallel_chunks(points.size(), threads, 1024, {},
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
    const NoiseEstimate noise = estimate_noise(points, noise_options);
    parallel_for(
        points.size(), threads, {},
        [&](std::size_t i) { thresholds[i] = std::max(thresholds[i], automatic_sigmas * noise.sigma_at(points[i])); },
        1024);
    return thresholds;
}

} // namespace

DelaunayBallNormals find_delaunay_ball_normals(const Points& input, const DelaunayBallOptions& options,
                                               const Progress& progress)
{
    check(options);
    const int threads = resolve_threads(options.threads);
    check_spans_volume(input);
    const UnitFrame frame(input);
    const SpatialOrder spatial = order_spatially(input);
    const int n = int(spatial.order.size());
    Points points;
    for (int i : spatial.order)
        points.push_back(frame.to_unit(input[i]));
    const std::vector<double> threshold = find_thresholds(points, options, threads);

    Points with_box = points;
    for (int corner = 0; corner < 8; ++corner)
        with_box.emplace_back(corner & 1 ? box_half_width : -box_half_width,
                              corner & 2 ? box_half_width : -box_half_width,
                              corner & 4 ? box_half_width : -box_half_width);
    const Triangulation t = triangulate_delaunay(with_box, progress.part(0, 0.7, "Delaunay triangulation"), threads);
    progress.part(0.7, 1, "Normals").report(0);

    std::vector<double> radius(t.finite_cells);
    std::vector<char> big(t.finite_cells, 0);
    std::vector<int> biggest(n, -1);
    for (int c = 0; c < t.finite_cells; ++c)
    {
        radius[c] = (t.centres[c] - with_box[t.cells[c].vertices[0]]).norm();
        for (int v : t.cells[c].vertices)
        {
            if (v >= n)
                big[c] = 1;
            else if (radius[c] > threshold[v])
            {
                big[c] = 1;
                if (biggest[v] < 0 || radius[c] > radius[biggest[v]])
                    biggest[v] = c;
            }
        }
    }

    const int outside = t.finite_cells;
    DisjointSets parts(std::size_t(outside) + 1);
    for (int c = 0; c < t.finite_cells; ++c)
        for (int o : t.cells[c].neighbours)
        {
            if (!t.is_finite(o))
                parts.join(c, outside);
            else if (o > c && big[c] && big[o])
            {
                const double cosine =
                    (radius[c] * radius[c] + radius[o] * radius[o] - (t.centres[c] - t.centres[o]).squaredNorm()) /
                    (2 * radius[c] * radius[o]);
                if (cosine > deep_cosine)
                    parts.join(c, o);
            }
        }

    DelaunayBallNormals result;
    Vectors normals(n, Vector::Zero());
    Points own;
    std::vector<int> own_index;
    for (int v = 0; v < n; ++v)
    {
        const int c = biggest[v];
        if (c < 0)
            continue;
        const double side = parts.find(c) == parts.find(outside) ? 1 : -1;
        const Vector direction = (t.centres[c] - points[v]) / std::max(radius[c], 1e-300);
        normals[v] = side * direction.normalized();
        own.push_back(points[v]);
        own_index.push_back(v);
        if (radius[c] < widest_pole)
            result.poles.push_back(frame.from_unit(t.centres[c]));
    }
    if (own.empty())
        throw AlgorithmFailure(
            "No Delaunay ball is big: the noise is as thick as the shape. Lower the ratio of a big ball.");
    result.with_big_ball = int(own.size());

    // The biggest big ball on the other side of each point that has one.
    std::vector<int> opposite(n, -1);
    for (int c = 0; c < t.finite_cells; ++c)
        for (int v : t.cells[c].vertices)
            if (v < n && biggest[v] >= 0 && radius[c] > threshold[v] && radius[c] < widest_pole &&
                (t.centres[c] - points[v]).dot(t.centres[biggest[v]] - points[v]) < 0 &&
                (opposite[v] < 0 || radius[c] > radius[opposite[v]]))
                opposite[v] = c;
    for (int v = 0; v < n; ++v)
        if (opposite[v] >= 0)
            result.poles.push_back(frame.from_unit(t.centres[opposite[v]]));

    // Every sample must take part in N and W, or only the envelopes of the noise would.
    const NeighbourSearch search(own);
    const int spread = options.normal_spread;
    parallel_chunks(std::size_t(n), threads, 1024, {},
                    [&](std::size_t begin, std::size_t end)
                    {
                        std::vector<int> near(spread);
                        std::vector<double> squared(spread);
                        for (std::size_t v = begin; v < end; ++v)
                        {
                            if (biggest[v] >= 0)
                                continue;
                            const int count = search.nearest(points[v], spread, near.data(), squared.data());
                            Vector sum = Vector::Zero();
                            for (int k = 0; k < count; ++k)
                                sum += normals[own_index[near[k]]];
                            normals[v] = sum.norm() > 1e-9 ? sum.normalized() : normals[own_index[near[0]]];
                        }
                    });
    result.normals.resize(input.size());
    for (std::size_t i = 0; i < input.size(); ++i)
        result.normals[i] = normals[spatial.representative[i]];
    return result;
}

} // namespace recon
