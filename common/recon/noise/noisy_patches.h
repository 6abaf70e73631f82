#pragma once

#include <recon/geometry.h>
#include <recon/search/block_search.h>

#include <vector>

namespace recon
{

/// Less noise is no news: coarse clean clouds read as having that at most places [spacings].
constexpr double least_noise_told = 0.2;

/// What is known of the noise at a seed.
struct SeedNoise
{
    double sigma = 0;          ///< Noise there [length].
    double region = 0;         ///< That of the region around [length].
    double spacing = 0;        ///< Distance of neighbouring samples [length].
    double region_spacing = 0; ///< That of the region around [length].
    bool settled = false;      ///< Whether a wider neighbourhood tells the same.
    bool two_sheets = false;   ///< Whether the neighbours lie on two sheets.
};

/// Whether the residual at a seed exceeds a little noise of the region around by so much that it is another noise, or
/// detail. Not where samples are sparser by far: outliers.
bool exceeds_region(const SeedNoise& seed);

/// Per seed, whether it lies in a patch of noisier samples than a region with little noise, as where scans of several
/// qualities meet or a scanner grazed the surface, and not at a thin part, an edge or other detail, which leave
/// residuals, too: half of the seeds around exceed the region's noise by a factor, some of these have settled and not
/// too many see two sheets, and neighbours do not lie flat there. Noisy seeds beside such ones are of the patch, too.
/// \param samples in spatial order. \param search of them.
std::vector<char> find_noisy_patches(const Points& samples, const BlockSearch& search, const Points& seeds,
                                     const std::vector<SeedNoise>& noise, int threads);

/// Whether the neighbours of these places lie as in noise, and not flat as those of coarse exact detail mostly do.
/// False if there are none.
bool lie_in_noise(const Points& samples, const BlockSearch& search, const Points& places, int threads);

} // namespace recon
