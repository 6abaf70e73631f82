#include "usable_samples.h"

#include <recon/parallel.h>
#include <recon/search/neighbours.h>
#include <recon/search/spatial_order.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace recon::pn
{
namespace
{

double distance(const Point& a, const Point& b)
{
    return (a - b).norm();
}

/// By the distance to the fourth nearest point elsewhere, which random clusters do not change much.
std::vector<char> find_isolated(const Points& points, const NearestTable& nearest, int threads)
{
    constexpr double far = 6;                  // times what is usual around
    const int k = std::min(nearest.count, 10); // itself, up to three more normals at a corner, and those around
    std::vector<double> distances(points.size(), 0);
    parallel_for(points.size(), threads, {},
                 [&](std::size_t i)
                 {
                     for (int m = 0, elsewhere = 0; m < k && elsewhere < 4; ++m)
                         if (const double d = distance(points[i], points[std::size_t(nearest.of(i)[m])]); d > 0)
                         {
                             distances[i] = d;
                             ++elsewhere;
                         }
                 });
    std::vector<char> is_isolated(points.size(), 0);
    parallel_for(points.size(), threads, {},
                 [&](std::size_t i)
                 {
                     double around[NearestTable::each];
                     int n = 0;
                     for (int m = 0; m < k; ++m)
                         if (const auto j = std::size_t(nearest.of(i)[m]); distance(points[i], points[j]) > 0)
                             around[n++] = distances[j];
                     if (n < 3)
                         return;
                     std::nth_element(around, around + n / 2, around + n);
                     is_isolated[i] = distances[i] > far * around[n / 2];
                 });
    return is_isolated;
}

void leave_out(const std::vector<char>& is_isolated, UsableSamples& usable)
{
    std::vector<int> kept_as;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < is_isolated.size(); ++i)
    {
        kept_as.push_back(int(kept));
        if (is_isolated[i])
            continue;
        usable.samples.points[kept] = usable.samples.points[i];
        usable.samples.normals[kept] = usable.samples.normals[i];
        usable.input[kept] = usable.input[i];
        // Points at one place are isolated together or not at all.
        usable.sharing[kept] = kept_as[std::size_t(usable.sharing[i])];
        ++kept;
    }
    usable.isolated += int(is_isolated.size() - kept);
    usable.samples.points.resize(kept);
    usable.samples.normals.resize(kept);
    usable.input.resize(kept);
    usable.sharing.resize(kept);
}

} // namespace

std::vector<int> next_at_position(const UsableSamples& usable)
{
    std::vector<int> next(usable.input.size());
    std::iota(next.begin(), next.end(), 0);
    for (std::size_t i = 0; i < next.size(); ++i)
        if (const auto first = std::size_t(usable.sharing[i]); first != i)
            std::swap(next[i], next[first]);
    return next;
}

void update_nearest(UsableSamples& usable, int threads, const Progress& progress)
{
    usable.search = std::make_unique<BlockSearch>(usable.samples.points, threads);
    usable.nearest = find_nearest(usable.samples.points, *usable.search, threads, progress);
}

std::vector<char> add_to_nearest(UsableSamples& usable, std::size_t first_added, int threads, const Progress& progress)
{
    const Points& points = usable.samples.points;
    const NearestTable before = std::move(usable.nearest);
    if (before.count < NearestTable::each)
    {
        update_nearest(usable, threads, progress);
        return std::vector<char>(points.size(), 1);
    }
    usable.search = std::make_unique<BlockSearch>(points, threads);
    NearestTable& table = usable.nearest;
    table.count = before.count;
    table.index.resize(points.size() * std::size_t(table.count));
    const Points added(points.begin() + std::ptrdiff_t(first_added), points.end());
    const NeighbourSearch added_search(added);
    std::vector<char> is_changed(points.size(), 1);
    parallel_for(points.size(), threads, progress,
                 [&](std::size_t i)
                 {
                     int* const row = table.index.data() + i * std::size_t(table.count);
                     double reach;
                     if (i < first_added)
                     {
                         const int* const old = before.of(i);
                         reach = distance(points[i], points[std::size_t(old[before.count - 1])]);
                         const double to_added =
                             distance(points[i], added[std::size_t(added_search.nearest(points[i]))]);
                         is_changed[i] = to_added < 2 * reach; // open fans look farther than the table
                         if (to_added > reach)
                         {
                             std::copy_n(old, table.count, row);
                             return;
                         }
                     }
                     else
                     {
                         auto known = i;
                         while (known >= first_added)
                             known = std::size_t(usable.beside[known]);
                         reach = distance(points[i], points[known]) +
                                 distance(points[known], points[std::size_t(before.of(known)[before.count - 1])]);
                     }
                     double squared[NearestTable::each];
                     usable.search->nearest(points[i], table.count, row, squared, reach);
                 });
    return is_changed;
}

void choose_usable_samples(const OrientedSamples& input, const std::vector<char>& is_isolated, const UnitFrame& frame,
                           double crease_angle, int threads, const Progress& progress, UsableSamples& usable)
{
    const double same = std::cos(crease_angle);
    const SpatialOrder places = order_input(input.points, threads);
    std::vector<int> end(places.order.size(), 0), points(input.points.size()); // points place by place, ascending
    for (int place : places.representative)
        ++end[std::size_t(place)];
    std::exclusive_scan(end.begin(), end.end(), end.begin(), 0);
    for (std::size_t i = 0; i < points.size(); ++i)
        points[std::size_t(end[std::size_t(places.representative[i])]++)] = int(i);
    progress.report(0.3);

    OrientedSamples& samples = usable.samples;
    auto next = points.begin();
    for (const int end_of_place : end)
    {
        const auto first = samples.points.size();
        for (; next != points.begin() + end_of_place; ++next)
        {
            if (!is_isolated.empty() && is_isolated[std::size_t(*next)])
            {
                ++usable.isolated;
                continue;
            }
            const Vector& normal = input.normals[std::size_t(*next)];
            const double largest = normal.cwiseAbs().maxCoeff();
            if (!normal.allFinite() || !(largest > 0))
            {
                ++usable.without_normal;
                continue;
            }
            const Vector unit = (normal / largest).normalized();
            if (std::any_of(samples.normals.begin() + std::ptrdiff_t(first), samples.normals.end(),
                            [&](const Vector& other) { return other.dot(unit) >= same; }))
            {
                ++usable.duplicates;
                continue;
            }
            // A unit normal keeps its bits.
            samples.points.push_back(frame.to_unit(input.points[std::size_t(*next)]));
            samples.normals.push_back(std::abs(normal.squaredNorm() - 1) < 1e-14 ? normal : unit);
            usable.input.push_back(*next);
            usable.sharing.push_back(int(first));
        }
    }

    update_nearest(usable, threads, progress.part(0.3, 0.9, "choosing points"));
    const std::size_t before = usable.input.size();
    leave_out(find_isolated(samples.points, usable.nearest, threads), usable);
    if (usable.input.size() < before && !usable.input.empty())
        update_nearest(usable, threads);
    usable.beside.resize(usable.input.size());
    std::iota(usable.beside.begin(), usable.beside.end(), 0);
    usable.is_crease.assign(usable.input.size(), 0);
    usable.is_frozen.assign(usable.input.size(), 0);
    for (std::size_t i = 0; i < usable.input.size(); ++i)
        if (const auto first = std::size_t(usable.sharing[i]); first != i)
            usable.is_crease[i] = usable.is_crease[first] = 1;
}

} // namespace recon::pn
