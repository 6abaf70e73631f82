#pragma once

#include <recon/geometry.h>

#include <array>
#include <vector>

namespace recon::pn
{

/// Samples put where the input has none, before the first step: onto creases, into holes, into voids, into folds.
struct AddedSamples
{
    OrientedSamples samples;
    std::vector<std::array<int, 3>>
        parents; ///< Usable samples, or (from their number on) samples added before this one.
};

/// Indices of the points along a curve through space, equal ones in their order: what is appended to the samples must
/// be neighbours in memory where it is in space, else every search among them takes longer.
std::vector<int> sort_spatially(const Points& points);

/// A place for a sample.
struct ProposedSample
{
    Point point;
    Vector normal;
    double worth;   ///< Of two that are too near to each other the one that is worth more stays.
    double spacing; ///< Of the input here.
    std::array<int, 3> parents;
};

/// Of samples of one side nearer to each other than `room` [spacings] those that are worth most, in spatial order.
AddedSamples thin_out(std::vector<ProposedSample> proposed, double room);

constexpr double same_side_of_fold = 0.5; ///< Normals that agree more lie on one side of a fold.

} // namespace recon::pn
