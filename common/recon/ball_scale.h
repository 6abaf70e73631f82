#pragma once

#include <recon/geometry.h>
#include <recon/neighbours.h>
#include <recon/polar_balls.h>
#include <recon/progress.h>

#include <array>
#include <vector>

namespace recon
{

/// Spacing of the samples around each of them, found at a subset and copied to the rest from the nearest of the subset.
struct SampleSpacing
{
    std::vector<int> subset;  ///< At most 20,000 samples at an even stride.
    std::vector<int> nearest; ///< Per sample: position in `subset` of the nearest of them.
    std::vector<std::array<int, 3>> mates; ///< Likewise its 3 nearest samples, -1 where there are fewer.
    std::vector<double> eighth; ///< Likewise distance to the 8th nearest sample.
    std::vector<double> fine;   ///< sqrt(2 x mean squared distance to the 6 nearest).
    std::vector<double> coarse; ///< The same with 30, median over the 9 nearest members.
};

/// \param search over `samples`.
SampleSpacing measure_spacing(const Points& samples, const NeighbourSearch& search, int threads,
                              const Progress& progress = {});

/// What a ball must have to count as evidence, per sample.
struct BallScale
{
    std::vector<double> scale;     ///< s: radius of the disc that holds the samples the scale was taken from [length].
    std::vector<double> density;   ///< lambda: samples per area [1/length^2].
    std::vector<double> threshold; ///< c s: smallest polar ball kept [length].
    double median_spacing = 0;     ///< Median fine scale [length].
};

/// The scale at each sample: fine where most samples around have two long opposite poles (noise below the spacing) or, at thin
/// walls, neighbours that lie flat; else coarse.
/// \param noise standard deviation of the noise, which then decides between fine and coarse; 0 = unknown.
BallScale choose_scale(const SampleSpacing& spacing, const Points& samples, const Triangulation& delaunay,
                       const Poles& poles, double noise = 0, int threads = 1);

/// The scale that assumes samples without noise, for points already projected onto a surface.
BallScale choose_fine_scale(const SampleSpacing& spacing);

} // namespace recon
