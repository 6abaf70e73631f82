#pragma once

#include <recon/geometry.h>
#include <recon/parallel.h>

#include <algorithm>
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

/// The largest of value(item) over a run, at least 0.
template <class Value>
double largest_in(const Run& run, Value&& value)
{
    double largest = 0;
    for (int i = run.begin; i < run.end; ++i)
        largest = std::max(largest, value(i));
    return largest;
}

/// Calls visit(worker, run) for all runs; make() makes a worker, of which each belongs to one thread.
template <class Make, class Visit>
void visit_runs(const std::vector<Run>& runs, int threads, const Progress& progress, Make&& make, Visit&& visit)
{
    constexpr std::size_t grain = 64;
    parallel_chunks(runs.size(), threads, grain, progress,
                    [&](std::size_t begin, std::size_t end)
                    {
                        auto worker = make();
                        for (std::size_t r = begin; r < end; ++r)
                            visit(worker, runs[r]);
                    });
}

} // namespace recon
