#include <recon/keep_apart.h>

#include <recon/neighbours.h>

namespace recon
{

std::vector<int> keep_apart(const Points& points, const std::vector<double>& radii)
{
    const NeighbourSearch search(points);
    std::vector<char> is_taken(points.size(), 0);
    std::vector<int> near, result;
    for (int i = 0; i < int(points.size()); ++i)
    {
        if (is_taken[i])
            continue;
        result.push_back(i);
        search.within(points[i], radii[i], near);
        for (const int other : near)
            is_taken[other] = 1;
    }
    return result;
}

} // namespace recon
