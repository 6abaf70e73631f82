#pragma once

#include <recon/progress.h>

#include <cstdint>
#include <vector>

namespace recon
{

/// Constraint between two balls, or between a ball and the outside.
struct Tie
{
    int a, b;
    float weight; ///< How certain it is, > 0.
    bool opposite;
};

/// Side of each ball (1 = that of the outside, else -1).
struct BallLabels
{
    std::vector<std::int8_t> side;
    double contradicted = 0; ///< Share of the weight of the ties that the labels violate [0..1].
};

/// Labels balls 0..balls - 1 by ties; `balls` itself stands for the outside. The maximum spanning forest decides first;
/// its greatest fault is that one wrong tie turns all over that hangs on it, however much the other ties object. So
/// then whole subtrees change sides where that lowers the weight violated. That ends where no subtree gains, so it
/// begins from two forests, one of which holds opposite ties for more certain, and the better end stays.
/// \throws Cancelled.
BallLabels label_balls(int balls, const std::vector<Tie>& ties, int threads, const Progress& progress = {});

} // namespace recon
