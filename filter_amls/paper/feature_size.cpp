#include "feature_size.h"

#include <recon/errors.h>
#include <recon/parallel.h>
#include <recon/search/block_search.h>
#include <recon/search/neighbours.h>
#include <recon/search/spatial_order.h>
#include <recon/triangulation/delaunay.h>
#include <recon/triangulation/polar_balls.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recon
{
namespace
{

constexpr double least_spacings = 2;     // radius; smaller balls are gaps between the points
constexpr double least_cosine = 0.8;     // between the direction to the pole and the normal
constexpr double least_separation = 0.5; // largest distance of the touched points [radius]
constexpr double farthest_pole = 1;      // diagonals: balls of the outside that only the box bounds

bool is_medial(const Triangulation& t, const Points& points, int cell, int point, const Vector& normal, double spacing)
{
    const Vector to_centre = t.centres[cell] - points[point];
    const double radius = to_centre.norm();
    if (radius < least_spacings * spacing || radius > farthest_pole ||
        std::abs(to_centre.dot(normal)) < least_cosine * radius)
        return false;
    double separation = 0;
    for (int a : t.cells[cell].vertices)
        for (int b : t.cells[cell].vertices)
            if (a < int(points.size()) && b < int(points.size()))
                separation = std::max(separation, (points[a] - points[b]).squaredNorm());
    return separation > least_separation * least_separation * radius * radius;
}

} // namespace

PolarCells find_polar_cells(const Points& points, const Vectors& normals, int threads, const Progress& progress)
{
    const int n = int(points.size());
    Points with_box = points;
    append_box_corners(with_box);
    PolarCells result;
    result.delaunay = triangulate_delaunay(with_box, progress, threads);
    const Triangulation& t = result.delaunay;
    result.outer.assign(n, -1);
    result.inner.assign(n, -1);
    std::vector<double> farthest_out(n, 0), farthest_in(n, 0);
    for (int c = 0; c < t.finite_cells; ++c)
        for (int v : t.cells[c].vertices)
        {
            if (v >= n)
                continue;
            const Vector to_centre = t.centres[c] - points[v];
            const double squared = to_centre.squaredNorm();
            const bool out = to_centre.dot(normals[v]) > 0;
            double& farthest = (out ? farthest_out : farthest_in)[v];
            if (squared > farthest)
            {
                farthest = squared;
                (out ? result.outer : result.inner)[v] = c;
            }
        }
    return result;
}

Points select_poles(const Triangulation& delaunay, const Points& points, const Vectors& normals,
                    const std::vector<double>& spacing, const std::vector<int>& outer, const std::vector<int>& inner)
{
    Points poles;
    for (int v = 0; v < int(points.size()); ++v)
        for (int cell : {outer[v], inner[v]})
            if (cell >= 0 && is_medial(delaunay, points, cell, v, normals[v], spacing[v]))
                poles.push_back(delaunay.centres[cell]);
    return poles;
}

std::vector<double> measure_feature_size(const Points& queries, const Points& poles, const FeatureSizeOptions& options,
                                         const Progress& progress)
{
    if (options.smoothing < 0)
        throw InvalidInput("The number of points for smoothing must be 0 (none) or more.");
    const int threads = resolve_threads(options.threads);
    const Points sorted = points_at(order_spatially(poles, threads).order, poles);
    const BlockSearch search(sorted, threads);
    std::vector<double> raw(queries.size(), std::numeric_limits<double>::infinity());
    const bool is_smoothed = options.smoothing >= 2;
    parallel_for(
        queries.size(), threads, progress.part(0, is_smoothed ? 0.3 : 1),
        [&](std::size_t i)
        {
            const int pole = search.nearest(queries[i]);
            if (pole >= 0)
                raw[i] = (sorted[pole] - queries[i]).norm();
        },
        1024);
    if (!is_smoothed)
        return raw;
    std::vector<double> smooth(raw.size());
    const NeighbourSearch points(queries);
    const int wanted = int(std::min(std::size_t(options.smoothing), queries.size()));
    parallel_chunks(queries.size(), threads, 1024, progress.part(0.3, 1),
                    [&](std::size_t begin, std::size_t end)
                    {
                        std::vector<int> near(wanted);
                        std::vector<double> squared(wanted);
                        for (std::size_t i = begin; i < end; ++i)
                        {
                            const int count = points.nearest(queries[i], wanted, near.data(), squared.data());
                            double sum = 0;
                            for (int k = 0; k < count; ++k)
                                sum += raw[near[k]];
                            smooth[i] = sum / count;
                        }
                    });
    return smooth;
}

} // namespace recon
