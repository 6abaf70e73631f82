#include "normal_repair.h"

#include <recon/parallel.h>

#include <algorithm>
#include <cmath>

namespace recon::pn
{

std::vector<int> turn_contradicting_normals(OrientedSamples& samples, const NearestTable& nearest,
                                            const std::vector<char>& is_frozen, int threads, const Progress& progress)
{
    const std::size_t n = samples.points.size();
    const int k = std::min(nearest.count, 13); // itself and 12 others
    std::vector<char> is_turned(n, 0), contradicts(n, 0);
    for (int round = 0; round < 8; ++round)
    {
        parallel_for(n, threads, progress.part(0.125 * round, 0.125 * (round + 1), "normals"),
                     [&](std::size_t i)
                     {
                         if (is_frozen[i])
                             return;
                         // Only neighbours that lie in both tangent planes vote: the other side of a thin part has
                         // opposite normals by right.
                         double agree = 0, contradict = 0;
                         for (int m = 0; m < k; ++m)
                         {
                             const int j = nearest.of(i)[m];
                             if (j == int(i))
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
