#include <recon/nearest_samples.h>

#include <recon/block_search.h>
#include <recon/parallel.h>

namespace recon
{

NearestSamples find_nearest_samples(const Points& points, const Points& samples, int threads, const Progress& progress)
{
    constexpr std::size_t grain = 4096;
    const BlockSearch search(samples);
    NearestSamples result{std::vector<int>(points.size()), std::vector<double>(points.size())};
    parallel_chunks(points.size(), threads, grain, progress,
                    [&](std::size_t begin, std::size_t end)
                    {
                        int sample = search.nearest(points[begin]);
                        for (std::size_t i = begin; i < end; ++i)
                        {
                            sample = search.nearest_from(points[i], sample);
                            result.sample[i] = sample;
                            result.squared[i] = (points[i] - samples[sample]).squaredNorm();
                        }
                    });
    return result;
}

} // namespace recon
