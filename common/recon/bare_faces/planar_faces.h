#pragma once

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <vector>

namespace recon
{

/// Face in a plane, bounded by closed rims.
struct PlanarFace
{
    std::vector<std::array<int, 3>> triangles; ///< Indices of points, counter-clockwise.
    std::vector<int> rim;                      ///< Points on its rims, ascending.
};

/// What rims enclose.
struct PlanarFaces
{
    std::vector<PlanarFace> faces;
    std::size_t on_rims = 0; ///< Points that were not left out; 0 if there are no faces [count].
};

/// Whether so many of the points are all but this share of strays.
inline bool are_all_but(double strays, std::size_t on_rims, std::size_t points)
{
    return double(on_rims) >= (1 - strays) * double(points);
}

/// Joins points that lie on closed curves (the rims) and fills every second region from infinity inwards.
///
/// Rims: edges of the one-step crust (Gold and Snoeyink 2001: the circle through the ends of a Delaunay edge and one
/// Voronoi vertex beside it does not hold the other), then what closes gaps; the shortest first, two at most at a
/// point. A straight rim needs no points between its ends. \param points distinct, of unit scale. \param strays share
/// of the points that may lie on no rim and are left out [0..1]; where a smaller one above 0 does, a larger one changes
/// nothing. \returns no face if more do not.
PlanarFaces fill_planar_rims(const std::vector<Eigen::Vector2d>& points, double strays);

/// Whether nearly all points lie within `tolerance` of one line: planes through that differ in what few others they
/// hold, so that each would be taken for another one, and none has a rim.
bool lie_on_a_line(const std::vector<Eigen::Vector2d>& points, double tolerance);

/// Edges that only one of the triangles has, each (lower, higher) and ascending: what bounds them.
std::vector<std::array<int, 2>> list_border_edges(const std::vector<std::array<int, 3>>& triangles);

} // namespace recon
