#pragma once

#include "fit.h"
#include "weighted_sums.h"

namespace recon
{

/// An anchor's quadric over its width and over a narrower one, in one frame.
struct TwoWidths
{
    static constexpr double narrower = 0.6; ///< Of the width.

    Point position;
    TangentFrame frame{Vector::UnitZ()}; ///< Perhaps stretched.
    QuadricFit wide, narrow;             ///< Both in units of the wider width.
    bool comparable = false;             ///< Both fits are good.
};

/// Where the surface bends within the width the heights of the two fits differ by more than noise explains: there the
/// quadric goes towards the narrower fit, and past it where the difference is much larger (Richardson extrapolation),
/// so that bends lose bias and plain places keep the variance of the wider fit.
void correct_bends(std::vector<Anchor>& anchors, const std::vector<TwoWidths>& fits,
                   const std::vector<FitStart>& starts, int threads);

} // namespace recon
