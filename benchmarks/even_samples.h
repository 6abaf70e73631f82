#pragma once

#include "area_sampler.h"

#include <recon/search/keep_apart.h>

namespace benchmarks
{

/// Random points to choose from, per sample.
inline constexpr int draws_per_sample = 30;

/// Poisson disks: of random points those that keep 0.8 spacings from all that were kept.
inline recon::Points sample_evenly(AreaSampler& sampler, double draws, double spacing)
{
    recon::Points drawn;
    for (int i = 0; i < draws; ++i)
        drawn.push_back(sampler.draw());
    return recon::points_at(recon::keep_apart(drawn, std::vector<double>(drawn.size(), 0.8 * spacing)), drawn);
}

} // namespace benchmarks
