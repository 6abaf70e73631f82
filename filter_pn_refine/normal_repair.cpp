#include "normal_repair.h"

#include <recon/parallel.h>

#include <algorithm>
#include <cmath>

namespace recon::pn
{

std::vector<int> turn_contradicting_normals(OrientedSamples& samples, const NeighbourSearch& search, int threads,
                                            const Progress& progress)
{
    const std::size_t n = samples.points.size();
    constexpr int k = 13; // itself and 12 others
    std::vector<char> is_turned(n, 0), contradicts(n, 0);
    std::vector<int> nearest(n * k, -1);
    parallel_for(n, threads, progress.part(0, 0.8, "normals"),
                 [&](std::size_t i)
                 {
                     double squared[k];
                     search.nearest(samples.points[i], k, &nearest[i * k], squared);
                 });
    for (int round = 0; round < 8; ++round)
    {
        parallel_for(n, threads, progress.part(0.8 + 0.02 * round, 0.82 + 0.02 * round, "normals"),
                     [&](std::size_t i)
                     {
                         // Only neighbours that lie in both tangent planes vote: the other side of a thin part has
                         // opposite normals by right.
                         double agree = 0, contradict = 0;
                         for (int m = 0; m < k; ++m)
                         {
                             const int j = nearest[i * k + std::size_t(m)];
                             if (j < 0 || j == int(i))
                                 continue;
                             const Vector d = samples.points[std::size_t(j)] - samples.points[i];
                             const double length = d.norm();
                             if (length == 0 || std::abs(d.dot(samples.normals[i])) > 0.3 * length ||
                                 std::abs(d.dot(samples.normals[std::size_t(j)])) > 0.3 * length)
                                 continue;
                             const double cosine = samples.normals[i].dot(samples.normals[std::size_t(j)]);
                             (cosine > 0 ? agree : contradict) += std::abs(cosine);
                         }
                         contradicts[i] = contradict > 1.5 * agree && contradict > 1;
                     });
        bool any = false;
        for (std::size_t i = 0; i < n; ++i)
            if (contradicts[i])
            {
                samples.normals[i] = -samples.normals[i];
                is_turned[i] ^= 1;
                any = true;
            }
        if (!any)
            break;
    }
    std::vector<int> turned;
    for (std::size_t i = 0; i < n; ++i)
        if (is_turned[i])
            turned.push_back(int(i));
    return turned;
}

} // namespace recon::pn
