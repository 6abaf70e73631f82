#include "thin.h"

#include <recon/block_search.h>
#include <recon/parallel.h>
#include <recon/scramble.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>

namespace recon
{
namespace
{

/// Points asked at a time: enough for all threads, few enough that hardly one covers another of them.
constexpr std::size_t least_batch = 64, batches = 128;

std::vector<int> shuffled(int n)
{
    std::vector<int> order(n);
    std::iota(order.begin(), order.end(), 0);
    for (int i = n - 1; i > 0; --i)
        std::swap(order[i], order[scramble(std::uint64_t(i)) % std::uint64_t(i + 1)]);
    return order;
}

} // namespace

std::vector<int> thin_to_poisson_disks(const Points& points, const Vectors& normals, const std::vector<double>& radii,
                                       int threads)
{
    const BlockSearch search(points);
    const std::vector<int> order = shuffled(int(points.size()));
    const std::size_t batch = std::max(least_batch, order.size() / batches);
    std::vector<char> covered(points.size(), 0);
    std::vector<int> chosen, asked;
    std::vector<std::vector<int>> around(batch);
    for (auto next = order.begin(); next != order.end();)
    {
        asked.clear();
        for (; next != order.end() && asked.size() < batch; ++next)
            if (!covered[*next])
                asked.push_back(*next);
        parallel_for(
            asked.size(), threads, {},
            [&](std::size_t k)
            {
                const int i = asked[k];
                search.within(points[i], radii[i], around[k]);
                const auto hidden = [&](int j) { return !(normals[j].dot(normals[i]) > 0); };
                around[k].erase(std::remove_if(around[k].begin(), around[k].end(), hidden), around[k].end());
            },
            64);
        for (std::size_t k = 0; k < asked.size(); ++k)
        {
            if (covered[asked[k]])
                continue;
            chosen.push_back(asked[k]);
            for (const int j : around[k])
                covered[j] = 1;
        }
    }
    std::sort(chosen.begin(), chosen.end());
    return chosen;
}

} // namespace recon
