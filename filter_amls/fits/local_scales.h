#pragma once

#include "fit.h"

#include <recon/geometry.h>
#include <recon/noise/noise.h>
#include <recon/progress.h>
#include <recon/search/block_search.h>

#include <vector>

namespace recon
{

/// What the width of the Gaussian weights is chosen from, and the width, at one place.
struct LocalScale
{
    double sigma;   ///< Standard deviation of the noise [length], > 0.
    double density; ///< Points per area [1 / length^2], > 0.
    double width;   ///< h of the weights exp(-d^2 / h^2) [length], > 0.
};

/// Scales at the seeds of a noise estimate. A place has the scales of its nearest seed.
struct LocalScales
{
    NoiseEstimate seeds;
    std::vector<LocalScale> at_seed;
    double seed_reach = 0; ///< A small part of the distance of neighbouring seeds [length].

    const LocalScale& at(const Point& p) const { return at_seed[seeds.nearest_seed(p)]; }
};

/// Chooses the width at each seed by an unbiased estimate of the risk (README.md, step 2): heights of weighted quadrics
/// over a ladder of widths are linear smoothers z_j = sum l_j z, so the squared difference to the narrowest one, less
/// its variance, tells the bias, and sum l_j^2 the variance; their sum is smallest at the best width, which stays below
/// 0.15 diagonals. \pre `points` are distinct, finite, in spatial order (order_spatially()) and of unit scale. \param
/// noise seeds, noise and density of these points. \param search of the points. \throws Cancelled.
LocalScales choose_widths(const Points& points, const BlockSearch& search, const NoiseEstimate& noise, int threads,
                          const Progress& progress = {});

/// The same once sides are known, of the samples that count in a fit: else the wall behind, and the face across an
/// edge, pass for bends, which keeps widths narrow. \param normals outward, one per seed. \param clearance distance of
/// what faces elsewhere below which it counts all the same [narrowest widths]: bores so small show no bend else.
LocalScales choose_fit_widths(const FitSamples& samples, const Vectors& normals, const NoiseEstimate& noise,
                              double clearance, int threads, const Progress& progress = {});

} // namespace recon
