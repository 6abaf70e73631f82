#pragma once

#include <recon/geometry.h>
#include <recon/noise/scale_ladder.h>
#include <recon/search/block_search.h>

#include <vector>

namespace recon
{

/// The residual at the scale chosen is a little below the noise, since a ball cuts off its tails.
constexpr double noise_truncation = 1.055;
/// Seeds around each of which the median is taken.
constexpr int smoothing_seeds = 21;

/// Noise and density per seed, in input units.
struct PooledNoise
{
    std::vector<double> sigma, density;
};

/// Reorders the values. \param share of them that are smaller.
double quantile_of(double* values, int count, double share);
double middle_of(double* values, int count);

/// Medians of what the seeds around each saw. Noise is at most somewhat more than that of the region but in noisy
/// patches, where noisy seeds speak for noisy ones. \param told by each seed alone. \param scale of the unit frame.
/// \param samples the cloud.
PooledNoise pool_noise(const Points& samples, const BlockSearch& sample_search, const Points& seeds,
                       const std::vector<LocalNoise>& told, double scale, int threads);

} // namespace recon
