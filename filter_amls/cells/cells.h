#pragma once

#include "filter_amls/fits/local_scales.h"

#include <recon/geometry.h>
#include <recon/progress.h>
#include <recon/search/block_search.h>

#include <cstdint>
#include <vector>

namespace recon
{

/// Points averaged over small voxels: fewer, less noisy, evener than the points. Lengths in the unit of the points.
struct Cells
{
    Points means;
    std::vector<double> counts;     ///< Points per cell.
    std::vector<LocalScale> scales; ///< Noise, density and width at each cell.
    std::vector<int> seeds;         ///< Per cell: of the noise estimate, that whose scales it has; -1: its own.
    std::vector<int> cell_of_point; ///< Per point.

    int size() const { return int(means.size()); }
};

/// Averages points over voxels of edge 0.6 widths, rounded to half octaves so that neighbouring places share a grid
/// (README.md, step 3). Cells come in the order of their first point.
Cells average_cells(const Points& points, const LocalScales& scales, int threads, const Progress& progress = {});

enum class CellKind : std::uint8_t
{
    regular,
    stray,  ///< In the tails of the noise: takes normal and foot of a better neighbour, is no anchor.
    outlier ///< Isolated: has no part in the surface.
};

/// Unsigned normals of cells (README.md, step 4).
struct CellNormals
{
    Vectors normals;             ///< Unit length.
    Points feet;                 ///< Of the means on the local plane.
    std::vector<double> mass;    ///< Weighted points found, relative to what a surface of that density has [1].
    std::vector<double> company; ///< Of that what other cells contribute [1].
    std::vector<CellKind> kinds;
    std::vector<double>
        widening; ///< Factor by which the width had to grow for the neighbourhood to have an extent [1].
};
/// Where sparse parts lie beside dense ones, whose scales they have by their seed, their scales are replaced.
/// \param search of the cells' means.
CellNormals estimate_cell_normals(Cells& cells, const BlockSearch& search, int threads, const Progress& progress = {});

} // namespace recon
