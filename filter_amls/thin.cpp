#include "thin.h"

#include <recon/block_search.h>
#include <recon/scramble.h>

#include <algorithm>
#include <cstdint>
#include <numeric>

namespace recon
{
std::vector<int> thin_to_poisson_disks(const Points& points, const Vectors& normals, const std::vector<double>& radii)
{
    const BlockSearch search(points);
    std::vector<int> order(points.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(),
              [](int a, int b) { return scramble(std::uint64_t(a)) < scramble(std::uint64_t(b)); });
    std::vector<char> covered(points.size(), 0);
    std::vector<int> chosen, around;
    for (const int i : order)
    {
        if (covered[i])
            continue;
        chosen.push_back(i);
        search.within(points[i], radii[i], around);
        for (const int j : around)
            if (normals[j].dot(normals[i]) > 0)
                covered[j] = 1;
    }
    std::sort(chosen.begin(), chosen.end());
    return chosen;
}

} // namespace recon
