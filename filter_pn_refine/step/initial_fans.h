#pragma once

#include "filter_pn_refine/samples/nearest_table.h"

#include <recon/geometry.h>
#include <recon/progress.h>
#include <recon/search/block_search.h>

#include <vector>

namespace recon::pn
{

/// Natural one-rings of the input.
struct InitialFans
{
    std::vector<double> radius;     ///< Per point, enough to hold its fan and all points whose fans hold it. 0: no fan.
    std::vector<double> farthest;   ///< Per point: of its fan [length]; a fan that is kept gets its radius from it.
    std::vector<int> first, member; ///< Fans as compressed rows, counter-clockwise seen from outside.
    std::vector<double> widest_gap; ///< Per point [radians].
    std::vector<int> gap_from; ///< Per point: place in `member` of the neighbour before the widest gap, -1 without.
};

/// Finds for each point the fan of the accurate neighbourhood (section 4.2) over its 24 nearest points, or 64 where
/// those do not close it. `search` and `nearest` are of `samples.points`. \param factor radius in distances to the
/// farthest of the fan. \param is_crease per sample: shares its position. Near such samples neighbours' normals must
/// agree within `crease_angle` [radians]. \param before fans of the first samples, to be kept where `is_changed` is 0;
/// may be null.
InitialFans find_initial_fans(const OrientedSamples& samples, const BlockSearch& search, const NearestTable& nearest,
                              const std::vector<char>& is_crease, double crease_angle, double factor, int threads,
                              const Progress& progress, const InitialFans* before = nullptr,
                              const std::vector<char>& is_changed = {});

} // namespace recon::pn
