#pragma once

#include <recon/parallel.h>
#include <recon/search/block_search.h>

#include <algorithm>
#include <vector>

namespace recon::pn
{

/// The nearest points of each point, itself first (of several at one position the lowest index): asked for once, used
/// by every preparation.
struct NearestTable
{
    static constexpr int each = 24;
    std::vector<int> index; ///< `count` per point, nearest first.
    int count = 0;          ///< each, or the number of points if they are fewer.

    const int* of(std::size_t i) const { return index.data() + i * std::size_t(count); }
};

/// The points lie in spatial order.
inline NearestTable find_nearest(const Points& points, const BlockSearch& search, int threads,
                                 const Progress& progress = {})
{
    NearestTable table;
    table.count = int(std::min(points.size(), std::size_t(NearestTable::each)));
    table.index.resize(points.size() * std::size_t(table.count));
    parallel_chunks(points.size(), threads, 256, progress,
                    [&](std::size_t begin, std::size_t end)
                    {
                        double squared[NearestTable::each], reach = 0;
                        for (std::size_t i = begin; i < end; ++i)
                            search.nearest(points[i], table.count, table.index.data() + i * std::size_t(table.count),
                                           squared, reach);
                    });
    return table;
}

} // namespace recon::pn
