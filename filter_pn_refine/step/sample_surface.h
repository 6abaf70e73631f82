#pragma once

#include "filter_pn_refine/samples/usable_samples.h"
#include "level.h"

namespace recon::pn
{

/// Of the corners of a triangle.
using CornerNormals = std::array<const Vector*, 3>;

/// Moves a point made from a triangle, where the normals of its corners differ, onto the smooth surface that
/// interpolates the positions and normals of the samples around (HermiteSurface), and takes its normal: a triangle
/// knows three of them only. \param slack of its gradients. Leaves the point where it is beside creases and where that
/// surface is no good.
void move_onto_sample_surface(const UsableSamples& usable, double slack, const CornerNormals& normals, WorkPoint& made);

} // namespace recon::pn
