#include "thin.h"

#include <recon/parallel.h>
#include <recon/scramble.h>
#include <recon/search/block_search.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>

namespace recon
{
namespace
{

/// A disk with fewer of the points that the density there promises holds strays: noise beyond a tip or an edge, where
/// the surface runs on without end. Dense pieces are thinned and strays are not, so few of them would weigh as much as
/// many.
constexpr double stray_share = 0.45;
constexpr double region_radii = 5;
constexpr double enough_points = 10; // of a disk; fewer tell nothing
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
                                       const std::vector<double>& expected, int threads)
{
    const BlockSearch search(points, threads);
    const std::vector<int> order = shuffled(int(points.size()));
    const std::size_t batch = std::max(least_batch, order.size() / batches);
    std::vector<char> covered(points.size(), 0);
    std::vector<int> chosen, asked;
    std::vector<std::vector<int>> around(batch);
    std::vector<char> stray(batch);
    const auto find_facing = [&](int i, double radius, std::vector<int>& found)
    {
        search.within(points[i], radius, found);
        const auto hidden = [&](int j) { return !(normals[j].dot(normals[i]) > 0); };
        found.erase(std::remove_if(found.begin(), found.end(), hidden), found.end());
    };
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
                find_facing(i, radii[i], around[k]);
                const double count = double(around[k].size());
                stray[k] = expected[i] >= enough_points && count < stray_share * expected[i];
                if (!stray[k])
                    return;
                // Where the cloud itself is sparser than was told, so is all around.
                std::vector<int> region;
                find_facing(i, region_radii * radii[i], region);
                stray[k] = region_radii * region_radii * count < stray_share * double(region.size());
            },
            16);
        for (std::size_t k = 0; k < asked.size(); ++k)
        {
            if (covered[asked[k]] || stray[k])
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
