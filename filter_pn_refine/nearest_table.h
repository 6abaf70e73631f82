#pragma once

#include <recon/neighbours.h>
#include <recon/parallel.h>

#include <algorithm>
#include <vector>

namespace recon::pn
{

/// The nearest points of each point, itself first: asked for once, used by every preparation.
struct NearestTable
{
    static constexpr int each = 24;
    std::vector<int> index; ///< `count` per point, nearest first.
    int count = 0;          ///< each, or the number of points if they are fewer.

    const int* of(std::size_t i) const { return index.data() + i * std::size_t(count); }
};

inline NearestTable find_nearest(const Points& points, const NeighbourSearch& search, int threads,
                                 const Progress& progress = {})
{
    NearestTable table;
    table.count = int(std::min(points.size(), std::size_t(NearestTable::each)));
    table.index.resize(points.size() * std::size_t(table.count));
    parallel_for(points.size(), threads, progress,
                 [&](std::size_t i)
                 {
                     double squared[NearestTable::each];
                     search.nearest(points[i], table.count, table.index.data() + i * std::size_t(table.count), squared);
                 });
    return table;
}

} // namespace recon::pn
