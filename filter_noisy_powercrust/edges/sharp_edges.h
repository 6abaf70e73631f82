#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>

namespace recon
{

/// Puts back the sharp edges of a denoised crust, which a smooth surface rounds off. Where normals turn, wedges are
/// fitted to the noisy points (wedge.h). Where most of those along a bend explain the points far better than one
/// quadric does, vertices move onto them, and edges of the mesh flip onto the crease; bends that are round stay. The
/// mesh stays closed, oriented and of the same topology; no triangle turns over, and none that changes cuts another.
/// \param mesh closed, oriented, of about one vertex per sample. \param points noisy ones in spatial order, without
/// outliers, in the units of the mesh. \param threads >= 1. \returns the number of vertices that moved.
/// \throws Cancelled.
int restore_sharp_edges(TriangleMesh& mesh, const Points& points, int threads = 1, const Progress& progress = {});

} // namespace recon
