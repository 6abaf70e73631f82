#pragma once

#include <recon/geometry.h>

namespace benchmarks
{

/// CPU seconds of CGAL's Delaunay triangulation of the points, range insertion, exact predicates, nothing else: the
/// unit in which speed is told.
double time_bare_delaunay(const recon::Points& points);

} // namespace benchmarks
