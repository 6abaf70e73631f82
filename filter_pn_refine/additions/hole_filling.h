#pragma once

#include "filter_pn_refine/samples/added_samples.h"
#include "filter_pn_refine/samples/usable_samples.h"
#include "filter_pn_refine/step/initial_fans.h"

#include <recon/progress.h>

#include <array>
#include <functional>
#include <vector>

namespace recon::pn
{

/// What `refine` returns: appended points and their parents.
struct Refined
{
    Points points;
    Vectors normals;
    std::vector<std::array<int, 3>> parents;
};

using RefineCoarse = std::function<Refined(const OrientedSamples&, int steps, const Progress&)>;

struct FilledHoles
{
    AddedSamples added;
    bool has_rims = false; ///< Whether there is anything that a hole could begin at.
    int too_wide = 0;      ///< Holes that were left open for their size, as far as the coarse surface spans them.
};

/// Fills holes up to `hole_radius` [units of the samples]. Radii that overlap a hole, as the paper has it, are only
/// helpful among points as far apart as the hole is wide: so the samples around rims are thinned, to one distance after
/// the other, finest first, refined by `refine` until they are dense again, and of what that makes the points in the
/// holes are kept, as dense as the samples around each. None comes from frozen samples alone. \param spacing per
/// sample.
FilledHoles fill_holes(const UsableSamples& usable, const InitialFans& fans, const std::vector<float>& spacing,
                       double boundary_angle, double hole_radius, const RefineCoarse& refine, int threads,
                       const Progress& progress);

} // namespace recon::pn
