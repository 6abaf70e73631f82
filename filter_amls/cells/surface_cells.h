#pragma once

#include "cells.h"

#include <recon/geometry.h>
#include <recon/noise/noise.h>
#include <recon/noise/rounding.h>
#include <recon/progress.h>
#include <recon/search/block_search.h>

namespace recon
{

/// Cells of points, and what they were chosen by.
struct SurfaceCells
{
    NoiseEstimate noise;
    Cells cells;
    BlockSearch search; ///< Of the cells' means.
    CellNormals normals;
};

/// Steps 1 to 4 of README.md: noise, widths, cells, their unsigned normals. \param points distinct, in spatial order,
/// of unit scale. \param search of the points. \param given_noise standard deviation [length], 0 = estimate. \param
/// rounding that moved them, if that is known: the noise is no less than its error; of a depth camera's, where all
/// around are of one depth.
SurfaceCells make_cells(const Points& points, const BlockSearch& search, double given_noise, const Rounding& rounding,
                        int threads, PhaseTimes& times, const Progress& progress = {});

/// Share of the points that outliers are at most; more are no outliers, but points that are no surface.
inline constexpr double most_outliers = 0.6;

/// The same, and if there are outliers again without them, since they blur scales and are company of each other. Where
/// there are many, so are those like them (scattered_points.h), again until there are no more. They come last then,
/// each a cell. Not if hardly any lies far from all else: those are samples of thin, sparse walls.
SurfaceCells make_surface_cells(const Points& points, const BlockSearch& search, double given_noise,
                                const Rounding& rounding, int threads, PhaseTimes& times,
                                const Progress& progress = {});

/// Indices of the points in cells of kind outlier, ascending.
std::vector<int> list_outliers(const Cells& cells, const CellNormals& normals);

} // namespace recon
