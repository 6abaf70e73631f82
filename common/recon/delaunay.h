#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>

#include <array>
#include <vector>

namespace recon
{

/// A three-dimensional triangulation as flat arrays, without CGAL's types. Cells with an infinite vertex come last.
/// All cells are positively oriented: vertices 0, 1, 2 are counter-clockwise seen from vertex 3's opposite side.
struct Triangulation
{
    static constexpr int infinite = -1;

    struct Cell
    {
        std::array<int, 4> vertices;   ///< Indices of the input points; `infinite` for the infinite vertex.
        std::array<int, 4> neighbours; ///< Neighbour i lies opposite vertex i.
    };
    std::vector<Cell> cells;
    int finite_cells = 0;
    /// Per finite cell: the point with equal power to its four vertices (Delaunay: circumcentre). A vertex of the Voronoi
    /// or power diagram. Never outside the box of half width 1e6 units around the origin.
    Points centres;

    bool is_finite(int cell) const { return cell < finite_cells; }
};

/// Delaunay triangulation of distinct points (CGAL, exact predicates). Equal points are inserted once: the others do not
/// appear. Deterministic for a given order of points.
/// \pre points are finite, at least 4 are affinely independent.
/// \throws Cancelled.
Triangulation triangulate_delaunay(const Points& points, const Progress& progress = {});

/// Regular triangulation: dual of the power diagram of the balls (centres, weights = squared radii). Hidden balls do not
/// appear as a vertex of any cell.
Triangulation triangulate_regular(const Points& centres, const std::vector<double>& weights, const Progress& progress = {});

} // namespace recon
