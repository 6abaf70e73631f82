#pragma once

#include "cells.h"

#include <vector>

namespace recon
{

/// Which cells carry the surface. Where the surface is plain (one sheet, little bent) fewer do.
struct AnchorChoice
{
    std::vector<int> anchors;   ///< Cells at which quadrics are fitted, ascending.
    std::vector<int> landmarks; ///< Cells whose Delaunay balls tell the sides, ascending: an even thinner subset.
    /// Distance of neighbouring landmarks [length] where none were left out, per landmark: balls are measured in it.
    std::vector<double> landmark_spacing;
    /// Per cell: the landmark (a position in `landmarks`) on the same plain piece of surface, whose side it takes over.
    /// -1 where the surface is not plain, and of strays and outliers.
    std::vector<int> landmark_of_cell;
};

/// Thins the feet of regular cells: to one per voxel of half a width, those of largest mass; where the surface is plain
/// to one per 0.7 widths as anchors and to one per width as landmarks (README.md, step 5). Empty if there is no regular
/// cell.
AnchorChoice choose_anchors(const Cells& cells, const CellNormals& normals, int threads);

/// Anchors chosen for the widths of their cells thinned to one per voxel of half a width again, where `widths` are
/// larger: else the time of wide fits would grow with the square of the number of points.
/// \returns positions in `anchors`, ascending.
std::vector<int> thin_anchors(const std::vector<int>& anchors, const std::vector<double>& widths,
                              const CellNormals& normals);

} // namespace recon
