#pragma once

#include "filter_pn_refine/refine.h"

#include <cstddef>

namespace recon
{

/// Options of a test that does not ask for threads.
inline PnRefineOptions one_thread(int steps)
{
    PnRefineOptions options;
    options.steps = steps;
    options.threads = 1;
    return options;
}

/// What comes before the first step alone: of those made in it nothing is kept.
inline PnRefinement refine_before_steps(const OrientedSamples& samples, const PnRefineHints& hints = {})
{
    PnRefinement refined = refine_points(samples, one_thread(1), hints);
    const auto count =
        std::size_t(refined.crease_points + refined.hole_points + refined.void_points + refined.fold_points);
    refined.points.resize(count);
    refined.normals.resize(count);
    refined.radii.resize(count);
    refined.parents.resize(count);
    return refined;
}

} // namespace recon
