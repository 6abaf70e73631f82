#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>
#include <recon/triangulation/triangulation.h>

namespace recon
{

/// Delaunay triangulation of points (RegularTriangulation: exact predicates), with the circumcentres of its cells. Of
/// equal points only the first becomes a vertex. The same for any number of threads (>= 1). \pre points are finite; at
/// least 4 are affinely independent; coordinates of the order of 1 (UnitFrame). \throws Cancelled.
Triangulation triangulate_delaunay(const Points& points, const Progress& progress = {}, int threads = 1);

} // namespace recon
