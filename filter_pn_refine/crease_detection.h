#pragma once

#include "added_samples.h"
#include "usable_samples.h"

#include <recon/neighbours.h>

namespace recon::pn
{

/// Crease samples found in a cloud that has none: pairs of points at one position, one with each normal (samples 2 k
/// and 2 k + 1 of the result share their position). Where near points' normals differ by more than `crease_angle`
/// [radians], the crease runs along the intersection of their tangent planes; it is sampled about as densely as the
/// cloud.
AddedSamples detect_creases(const UsableSamples& usable, const NeighbourSearch& search, double crease_angle);

} // namespace recon::pn
