#include <recon/cleanness.h>

#include <recon/block_search.h>
#include <recon/delaunay.h>
#include <recon/parallel.h>
#include <recon/polar_balls.h>

#include <algorithm>
#include <cmath>

namespace recon
{

bool has_clean_poles(const Vector& first, const Vector& second, double eighth)
{
    return -first.dot(second) > 0.8 * first.norm() * second.norm() &&
           std::min(first.norm(), second.norm()) > 0.4 * eighth;
}

double share_of_flat(const Vector& first, const Point* neighbours, int count)
{
    int flat = 0;
    for (int i = 0; i < count; ++i)
        flat += neighbours[i].dot(first) > -0.3 * neighbours[i].norm() * first.norm();
    return count > 0 ? double(flat) / count : 1;
}

Cleanness measure_cleanness(const Points& samples, int threads)
{
    constexpr int seeds = 200, around = 32, flat_count = 3;
    const std::size_t n = samples.size();
    const std::size_t stride = std::max<std::size_t>(1, n / seeds), count = n == 0 ? 0 : (n - 1) / stride + 1;
    std::vector<int> clean(count, 0);
    std::vector<double> flat(count, 0);
    const BlockSearch search(samples);
    const auto examine = [&](std::size_t k)
    {
        const Point& centre = samples[k * stride];
        int indices[around];
        double squared[around];
        const int found = search.nearest(centre, around, indices, squared);
        if (found < 5)
            return;
        const double radius = std::sqrt(squared[found - 1]);
        Points local;
        for (int j = 0; j < found; ++j)
            local.push_back(0.5 / radius * (samples[indices[j]] - centre));
        append_box_corners(local);
        const Triangulation delaunay = triangulate_delaunay(local);
        const Poles poles = find_poles(delaunay, local);
        const auto& cells = poles.cells.front();
        if (cells[0] == Poles::none)
            return;
        flat[k] = share_of_flat(delaunay.centres[cells[0]], &local[1], flat_count);
        clean[k] =
            cells[1] != Poles::none && has_clean_poles(delaunay.centres[cells[0]], delaunay.centres[cells[1]],
                                                       0.5 / radius * std::sqrt(squared[std::min(8, found - 1)]));
    };
    parallel_for(count, threads, {}, examine, 8);
    Cleanness result;
    for (std::size_t k = 0; k < count; ++k)
    {
        result.long_cells += clean[k] / double(count);
        result.flat_neighbours += flat[k] / double(count);
    }
    return result;
}

} // namespace recon
