#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>

#include <vector>

namespace recon
{

class BlockSearch;

/// Per point.
struct NearestSamples
{
    std::vector<int> sample;     ///< Index of the nearest sample, of equally near ones the lowest.
    std::vector<double> squared; ///< Squared distance to it.
};

/// Fast where points that follow each other lie side by side. `threads` >= 1. \pre there are samples.
/// \throws Cancelled.
NearestSamples find_nearest_samples(const Points& points, const Points& samples, int threads = 1,
                                    const Progress& progress = {});

/// The same for many lists of points. \param search of the samples.
NearestSamples find_nearest_samples(const Points& points, const Points& samples, const BlockSearch& search, int threads,
                                    const Progress& progress = {});

} // namespace recon
