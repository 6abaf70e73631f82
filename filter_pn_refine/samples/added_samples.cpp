#include "added_samples.h"

#include <recon/search/neighbours.h>
#include <recon/search/spatial_order.h>

#include <algorithm>
#include <numeric>

namespace recon::pn
{

std::vector<int> sort_spatially(const Points& points)
{
    const std::vector<int> rank = order_spatially(points).representative;
    std::vector<int> sorted(points.size());
    std::iota(sorted.begin(), sorted.end(), 0);
    std::stable_sort(sorted.begin(), sorted.end(),
                     [&](int a, int b) { return rank[std::size_t(a)] < rank[std::size_t(b)]; });
    return sorted;
}

AddedSamples thin_out(std::vector<ProposedSample> proposed, double room)
{
    std::stable_sort(proposed.begin(), proposed.end(),
                     [](const ProposedSample& a, const ProposedSample& b) { return a.worth > b.worth; });
    Points points;
    for (const ProposedSample& p : proposed)
        points.push_back(p.point);
    const NeighbourSearch search(points);
    std::vector<char> is_kept(proposed.size(), 0);
    std::vector<int> near;
    for (std::size_t k = 0; k < proposed.size(); ++k)
    {
        const ProposedSample& p = proposed[k];
        search.within(p.point, room * p.spacing, near);
        is_kept[k] = std::none_of(near.begin(), near.end(),
                                  [&](int j) {
                                      return is_kept[std::size_t(j)] &&
                                             proposed[std::size_t(j)].normal.dot(p.normal) > same_side_of_fold;
                                  });
    }
    AddedSamples added;
    for (const int k : sort_spatially(points))
    {
        if (!is_kept[std::size_t(k)])
            continue;
        const ProposedSample& p = proposed[std::size_t(k)];
        added.samples.points.push_back(p.point);
        added.samples.normals.push_back(p.normal);
        added.parents.push_back(p.parents);
    }
    return added;
}

} // namespace recon::pn
