#include "spacing.h"

#include "local_points.h"

#include <recon/parallel.h>

#include <cmath>

namespace recon::pn
{

std::vector<float> find_spacing(const OrientedSamples& samples, const NearestTable& nearest, int threads)
{
    const std::size_t n = samples.points.size();
    const auto is_beside = [&](std::size_t i, int j)
    { return samples.normals[i].dot(samples.normals[std::size_t(j)]) >= double(least_agreement); };
    std::vector<float> spacing(n), mean(n);
    parallel_for(n, threads, {},
                 [&](std::size_t i)
                 {
                     const int* const near = nearest.of(i);
                     int count = 0;
                     for (int m = 0; m < nearest.count; ++m)
                         count += is_beside(i, near[m]);
                     const double squared =
                         (samples.points[i] - samples.points[std::size_t(near[nearest.count - 1])]).squaredNorm();
                     spacing[i] = float(std::sqrt(3.14159265 * squared / std::max(count, 1)));
                 });
    for (int pass = 0; pass < 2; ++pass)
    {
        parallel_for(n, threads, {},
                     [&](std::size_t i)
                     {
                         const int* const near = nearest.of(i);
                         float sum = 0;
                         int count = 0;
                         for (int m = 0; m < nearest.count; ++m)
                             if (is_beside(i, near[m]))
                             {
                                 sum += spacing[std::size_t(near[m])];
                                 ++count;
                             }
                         mean[i] = count > 0 ? sum / float(count) : spacing[i];
                     });
        spacing.swap(mean);
    }
    return spacing;
}

} // namespace recon::pn
