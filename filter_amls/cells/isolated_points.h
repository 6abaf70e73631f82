#pragma once

#include "cells.h"

#include <recon/geometry.h>
#include <recon/progress.h>
#include <recon/search/block_search.h>

#include <vector>

namespace recon
{

/// Indices of points of a clean cloud that have no part in its surface, ascending: of cells of kind outlier, if any
/// point lies farther from the nearest than this from its neighbours. Else those cells are lone vertices of a coarse
/// mesh. Where there are such, also strays: nearer ones, far off the quadric through their neighbours. None if they
/// were more than most_outliers (surface_cells.h) of all. \param points distinct, in spatial order. \param search,
/// cells, normals of these points.
std::vector<int> list_isolated_points(const Points& points, const BlockSearch& search, const Cells& cells,
                                      const CellNormals& normals, int threads);

/// The same, in a fiftieth of the time of a triangulation if no point lies alone, which most clean clouds have none of.
/// \param points in the unit frame. \throws Cancelled.
std::vector<int> find_isolated_points(const Points& points, int threads, const Progress& progress = {});

/// Per point of any cloud, distinct or not, whether it is such. \throws InvalidInput for points that are not finite.
std::vector<char> mark_isolated_points(const Points& points, int threads, const Progress& progress = {});

} // namespace recon
