#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>
#include <recon/triangulation/triangulation.h>

#include <vector>

namespace recon
{

/// Centres of the large Delaunay balls of a thin cloud: points near the medial axis.
/// A pole counts if its ball is wider than the gaps between the points, lies along the point's normal and touches
/// points that are well apart as seen from its centre: a ball that rests on a bump of remaining noise touches close
/// ones.
Points select_poles(const Triangulation& delaunay, const Points& points, const Vectors& normals,
                    const std::vector<double>& spacing, const std::vector<int>& outer, const std::vector<int>& inner);

/// Delaunay triangulation with a box of 5 diagonals around, and per point the finite cells with the farthest centre
/// along and against its normal, -1 if there is none.
struct PolarCells
{
    Triangulation delaunay; ///< Of the points, followed by the 8 corners of the box.
    std::vector<int> outer, inner;
};
/// \pre points are distinct and of unit scale (UnitFrame); normals of unit length.
PolarCells find_polar_cells(const Points& points, const Vectors& normals, int threads, const Progress& progress = {});

/// Options of measure_feature_size().
struct FeatureSizeOptions
{
    int smoothing = 0; ///< Number of nearest points over which the feature size is averaged [count], >= 0. 0 = none.
    int threads = 0;   ///< Threads to use [count], >= 0. 0 = all cores.
};

/// Distance from each query to the nearest pole [length]; infinity if there are no poles.
/// \throws InvalidInput for an option out of range. \throws Cancelled.
std::vector<double> measure_feature_size(const Points& queries, const Points& poles,
                                         const FeatureSizeOptions& options = {}, const Progress& progress = {});

} // namespace recon
