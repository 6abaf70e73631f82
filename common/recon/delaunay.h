#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>
#include <recon/triangulation.h>

namespace recon
{

/// Delaunay triangulation of points (CGAL, exact predicates), with the circumcentres of its cells. Of equal points only one
/// becomes a vertex. Deterministic for a given order of points. `threads` (>= 1) share what follows CGAL's insertion: its parallel
/// mode spins on locks, and on a busy machine took nine times the processor time.
/// \pre points are finite; at least 4 are affinely independent; coordinates of the order of 1 (UnitFrame).
/// \throws Cancelled.
Triangulation triangulate_delaunay(const Points& points, const Progress& progress = {}, int threads = 1);

} // namespace recon
