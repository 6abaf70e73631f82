#pragma once

#include <recon/geometry.h>

#include <vector>

namespace recon
{

/// Consecutive items that lie close together, so that one neighbour query serves all of them.
struct Run
{
    int begin, end;
    Point centre;
    double radius; ///< Of a ball around `centre` with all items.
};

/// Splits items in spatial order into runs whose bounding balls stay below reach(first item).
template <class Reach>
std::vector<Run> split_into_runs(const Points& items, int longest, Reach&& reach)
{
    std::vector<Run> runs;
    int begin = 0;
    const int n = int(items.size());
    while (begin < n)
    {
        Point low = items[begin], high = items[begin];
        const double limit = 2 * reach(begin);
        int end = begin + 1;
        for (; end < n && end - begin < longest; ++end)
        {
            const Point lower = low.cwiseMin(items[end]), upper = high.cwiseMax(items[end]);
            if ((upper - lower).squaredNorm() > limit * limit)
                break;
            low = lower;
            high = upper;
        }
        runs.push_back({begin, end, 0.5 * (low + high), 0.5 * (high - low).norm()});
        begin = end;
    }
    return runs;
}

} // namespace recon
