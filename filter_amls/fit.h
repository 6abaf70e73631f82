#pragma once

#include "cells.h"

#include <recon/geometry.h>
#include <recon/progress.h>

#include <array>
#include <vector>

namespace recon
{

/// A small piece of surface: the quadric d(x) = u.n - u^T Q u = 0, u = x - position.
struct Anchor
{
    Point position;
    Vector normal;                 ///< Unit length, outward.
    std::array<double, 6> bending; ///< Q: xx, yy, zz, xy, xz, yz.
    double confidence;             ///< Weight among other anchors, >= 0.
    double width;                  ///< h at the anchor [length].
};

/// Fits a quadric to the cells around each anchor, twice, the second time about the first and robustly (recipe step 7).
/// Where that fails, turns by more than 60 degrees or moves too far, the anchor stays the plane of its cell.
/// \param search of the cells' means. \param normals oriented, one per cell. \param feet of the cells. \param widths h
/// per anchor [length].
std::vector<Anchor> fit_anchors(const Cells& cells, const BlockSearch& search, const Vectors& normals,
                                const Points& feet, const std::vector<int>& anchors, const std::vector<double>& widths,
                                int threads, const Progress& progress = {});

} // namespace recon
