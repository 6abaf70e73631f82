#include <recon/search/keep_apart.h>

#include <recon/search/block_search.h>
#include <recon/search/spatial_order.h>

namespace recon
{

std::vector<int> keep_apart(const Points& points, const std::vector<double>& radii,
                            const std::function<bool(int)>& may_stay)
{
    const SpatialOrder spatial = order_spatially(points);
    const BlockSearch search(points_at(spatial.order, points));
    std::vector<char> is_taken(spatial.order.size(), 0); // equal points are all taken or none
    std::vector<int> near, result;
    for (int i = 0; i < int(points.size()); ++i)
    {
        if (is_taken[spatial.representative[i]] || (may_stay && !may_stay(i)))
            continue;
        result.push_back(i);
        search.within(points[i], radii[i], near);
        for (const int other : near)
            is_taken[other] = 1;
    }
    return result;
}

} // namespace recon
