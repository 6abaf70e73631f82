#pragma once

#include "cells.h"

#include <recon/geometry.h>
#include <recon/search/block_search.h>

namespace recon
{

/// In the tails of the noise a few points can look like a surface that stands across the true one. A cell whose normal
/// is across those around gets theirs, if these agree and the points there lie in a plane but for noise.
/// \param search of the points. \param cell_search of the cells' means. \param normals outward. \returns normals.
Vectors turn_cells_across(const Points& points, const BlockSearch& search, const Cells& cells,
                          const BlockSearch& cell_search, const CellNormals& normals, int threads);

} // namespace recon
