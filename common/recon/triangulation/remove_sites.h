#pragma once

#include <recon/geometry.h>
#include <recon/triangulation/triangulation.h>

#include <vector>

namespace recon
{

/// Takes vertices out of a regular triangulation: the cells at each leave a hole, which the cells of the regular
/// triangulation of its link fill. Moves few of the other cells. Vertices that were hidden stay so. \param points,
/// weights, triangulation as of RegularTriangulation. \returns false if a vertex lies on the hull or the holes need
/// more cells than they leave; the triangulation is of no use then.
bool remove_sites(Triangulation& triangulation, const Points& points, const std::vector<double>& weights,
                  const std::vector<int>& removed);

} // namespace recon
