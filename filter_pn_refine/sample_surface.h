#pragma once

#include "level.h"
#include "usable_samples.h"

namespace recon::pn
{

/// How far normals are off [radians], standard deviation per tangent axis: from the median difference of a normal to
/// what a linear fit to those around predicts. At most 5,000 samples, evenly spread, are asked. \pre `nearest` is
/// there.
double estimate_normal_noise(const UsableSamples& usable);

/// Moves a point made from the points of the level at these places, where their normals differ, onto the smooth surface
/// that interpolates the positions and normals of the samples around (HermiteSurface), and takes its normal: a triangle
/// knows three of them only. Where normals are noisy the surface meets them less closely. Leaves the point where it is
/// beside creases and where that surface is no good.
void move_onto_sample_surface(const UsableSamples& usable, double normal_noise, const std::vector<WorkPoint>& level,
                              const std::array<int, 3>& corners, WorkPoint& made);

} // namespace recon::pn
