#pragma once

#include "crust_of_points.h"
#include "filter_amls/cells/cells.h"

#include <recon/geometry.h>
#include <recon/progress.h>

#include <optional>
#include <vector>

namespace recon
{

/// Outward normals that know the sides of thin walls better than those of the cells do, which average both: of the
/// crust through the points as they are. None where the ties between anchors hardly contradict each other, where the
/// points are too noisy for such a crust, where it contradicts them or has filled the walls, or where both tell the
/// same but for a few points; of points that read as an open sheet also where it has lids. \param points distinct, in
/// the unit frame and spatial order. \param cells, cell_normals of these points. \param contradicted, open see
/// Orientation. \param of_points is asked where it is needed. \throws Cancelled.
std::optional<Vectors> find_sides_of_thin_walls(const Points& points, const Cells& cells, const Vectors& cell_normals,
                                                double contradicted, bool open, CrustOfPoints& of_points, int threads,
                                                const Progress& progress = {});

} // namespace recon
