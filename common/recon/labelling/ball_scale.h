#pragma once

#include <recon/geometry.h>
#include <recon/search/block_search.h>
#include <recon/triangulation/polar_balls.h>

#include <array>
#include <vector>

namespace recon
{

/// Spacing of the samples around each of them, found at a subset and copied to the rest from the nearest of the subset.
struct SampleSpacing
{
    std::vector<int> subset;               ///< At most 20,000 samples at an even stride.
    std::vector<int> nearest;              ///< Per sample: position in `subset` of the nearest of them.
    std::vector<std::array<int, 3>> mates; ///< Likewise its 3 nearest samples, -1 where there are fewer.
    std::vector<double> eighth;            ///< Likewise distance to the 8th nearest sample.
    std::vector<double> fine;              ///< sqrt(2 x mean squared distance to the 6 nearest).
    BlockSearch search;                    ///< Over the subset.
};

/// \param search over `samples`, here and below.
SampleSpacing measure_spacing(const Points& samples, const BlockSearch& search, int threads);

/// What a ball must have to count as evidence, per sample.
struct BallScale
{
    std::vector<double> scale;     ///< s: radius of the disc that holds the samples the scale was taken from [length].
    std::vector<double> density;   ///< lambda: samples per area [1/length^2].
    std::vector<double> threshold; ///< c s: smallest polar ball kept [length].
    double median_spacing = 0;     ///< Median fine scale [length].
};

/// The scale at each sample: fine where most samples around have two long opposite poles (noise below the spacing) or,
/// at thin walls, neighbours that lie flat; else coarse: as the fine one but with the 30 nearest, median over the 9
/// nearest members. \param noise standard deviation of the noise, which then decides between fine and coarse; 0 =
/// unknown.
BallScale choose_scale(const SampleSpacing& spacing, const Points& samples, const BlockSearch& search,
                       const Triangulation& delaunay, const Poles& poles, double noise = 0, int threads = 1);

/// The scale that assumes samples without noise, for points already projected onto a surface.
BallScale choose_fine_scale(const SampleSpacing& spacing);

} // namespace recon
