#pragma once

#include <recon/geometry.h>

#include <array>
#include <vector>

namespace recon
{

/// A three-dimensional triangulation as flat arrays.
struct Triangulation
{
    static constexpr int infinite = -1;

    struct Cell
    {
        std::array<int, 4> vertices;   ///< Indices of the input points; `infinite` for the infinite vertex.
        std::array<int, 4> neighbours; ///< Neighbour i lies opposite vertex i.

        /// Position of vertex v in the cell, 4 if it is none of its vertices.
        int position_of(int v) const { return find(vertices, v); }
        /// Position of the vertex across whose facet the cell lies, 4 if it is not a neighbour.
        int position_across(int cell) const { return find(neighbours, cell); }

    private:
        /// Without branches: nobody can predict them.
        static int find(const std::array<int, 4>& values, int value)
        {
            const int found = int(values[0] == value) | int(values[1] == value) << 1 | int(values[2] == value) << 2 |
                              int(values[3] == value) << 3;
            return found == 0 ? 4 : __builtin_ctz(unsigned(found));
        }
    };

    /// Positively oriented: vertex 3 sees 0, 1, 2 counter-clockwise from outside the cell. Finite cells come first.
    std::vector<Cell> cells;
    int finite_cells = 0;
    /// Per finite cell the point of equal power to its vertices (Delaunay: its circumcentre): a vertex of the Voronoi
    /// or power diagram.
    Points centres;

    bool is_finite(int cell) const { return cell < finite_cells; }

    /// False if a cell beside `cell` in the ring around the edge of its vertices at positions i and j is infinite or of
    /// lower index.
    bool can_be_lowest(int cell, int i, int j) const
    {
        const auto& neighbours = cells[cell].neighbours;
        for (int k = 0; k < 4; ++k)
            if (k != i && k != j && (neighbours[k] < cell || neighbours[k] >= finite_cells))
                return false;
        return true;
    }

    /// Cells around the edge from vertex a to vertex b of `cell` in cyclic order, counter-clockwise seen from b, if
    /// `cell` has the lowest index of them and all are finite; else returns false early. So a walk over all cells meets
    /// every bounded edge once. Replaces the content of `ring`.
    bool list_ring_from_lowest(int cell, int a, int b, std::vector<int>& ring) const;
};

/// Per point whether it is a vertex: in a power diagram some balls are hidden.
std::vector<char> mark_vertices(const Triangulation& triangulation, int point_count);

/// For each vertex the finite and infinite cells at it, as compressed rows: cells of v are cell[first[v]..first[v +
/// 1]).
struct CellsAtVertices
{
    std::vector<int> first;
    std::vector<int> cell;
};
CellsAtVertices list_cells_at_vertices(const Triangulation& triangulation, int vertex_count, int threads = 1);

} // namespace recon
