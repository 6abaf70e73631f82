#pragma once

#include "filter_amls/surface/surface.h"

#include <recon/geometry.h>
#include <recon/progress.h>

#include <vector>

namespace recon
{

/// Moves the vertices of a mesh onto an AMLS surface; its triangles stay what they are. A vertex that the surface does
/// not claim (over a hole of the scan), or that is farther from it than a spacing and three times the noise, stays;
/// where a triangle would turn over, its corners move half as far, and at last not at all. Lengths are in input units.
/// \param stays if not empty, per vertex: whether it is not to move. \returns which vertices moved. \throws Cancelled.
std::vector<char> smooth_mesh(TriangleMesh& mesh, const AmlsSurface& surface, int threads,
                              const Progress& progress = {}, const std::vector<char>& stays = {});

} // namespace recon
