#pragma once

#include <recon/geometry.h>
#include <recon/mesh/half_edges.h>

#include <vector>

namespace recon
{

/// Options of collapse_short_edges(). Lengths of edges count relative to the scale at their ends.
struct EdgeCollapseOptions
{
    double always_below = 0.3; ///< Edges shorter than this go in any case [scale], >= 0.
    double never_above = 1.0;  ///< Edges longer than this stay [scale].
    int target_vertices = 0;   ///< Between the two, until so many vertices are left [count].
    std::vector<char> stays;   ///< Per vertex: whether it stays where it is. Then all others go up to never_above,
                               ///< whatever the target. Empty: none.
    int threads = 1;           ///< [count], >= 1. The result does not depend on it.
};

/// Collapses short edges of a closed oriented manifold, by rising limits of length, each to its heavier end (the one
/// that has swallowed more vertices) or its midpoint. It stays a closed oriented manifold of the same topology (link
/// condition), and no triangle turns against the surface around it. Faux edges are forgotten.
///
/// \param half_edges of the mesh, none faulty.
/// \param scale per vertex, > 0.
/// \param merged per vertex: how many it stands for already.
/// \returns for each vertex that is left one of its former indices.
std::vector<int> collapse_short_edges(TriangleMesh& mesh, const HalfEdges& half_edges, const std::vector<double>& scale,
                                      const std::vector<int>& merged, const EdgeCollapseOptions& options);

} // namespace recon
