#pragma once

#include <recon/geometry.h>

#include <array>
#include <vector>

namespace recon
{

/// The others of a half-edge's triangle.
inline int next_half_edge(int h)
{
    return (h & 3) == 2 ? h - 2 : h + 1;
}
inline int previous_half_edge(int h)
{
    return (h & 3) == 0 ? h + 2 : h - 1;
}

/// Half-edges of a triangle mesh: half-edge 4 t + k leads from corner k of triangle t to the next one.
struct HalfEdges
{
    std::vector<std::array<int, 4>> twin; ///< Per triangle and corner: the half-edge back. The fourth is unused.
    std::vector<int> outgoing;            ///< Per vertex: a half-edge from it, -1 if it has none.
    std::vector<int> degree;              ///< Per vertex: triangles at it.
    std::vector<int> faulty;              ///< Triangles that cannot be part of a closed oriented manifold.
};

/// Finds the half-edges' twins. A triangle is faulty if one of its sides has not exactly one triangle that runs along
/// it each way, or one of its corners has fewer than three triangles; its twins mean nothing. `threads` >= 1.
HalfEdges pair_half_edges(const TriangleMesh& mesh, int threads = 1);

} // namespace recon
