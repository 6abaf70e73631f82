#pragma once

#include "level.h"
#include "usable_samples.h"

namespace recon::pn
{

/// Moves a point made from the points of the level at these places, where their normals differ, onto the smooth surface
/// that interpolates the positions and normals of the samples around (HermiteSurface), and takes its normal: a triangle
/// knows three of them only. \param slack of its gradients. Leaves the point where it is
/// beside creases and where that surface is no good.
void move_onto_sample_surface(const UsableSamples& usable, double slack, const std::vector<WorkPoint>& level,
                              const std::array<int, 3>& corners, WorkPoint& made);

} // namespace recon::pn
