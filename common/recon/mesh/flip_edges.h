#pragma once

#include <recon/mesh/half_edge_mesh.h>

#include <vector>

namespace recon
{

/// Options of flip_edges().
struct EdgeFlipOptions
{
    /// What a flip must save: the sum over the edges of length x difference of the unit normals, by the edges' length
    /// (> 0). Where less is at stake, a flip that makes the edge Delaunay is made.
    double gain = 0.02;
    int most_flips = 10; ///< Per triangle [count], 1..255.
    int threads = 1;     ///< [count], >= 1. The result does not depend on it.
};

/// Flips edges as long as that lowers the total bending of the five edges around: the sum of their length times the
/// difference of the normals beside them (total absolute mean curvature; Dyn, Hormann, Kim, Levin 2001: of all
/// triangulations of the same points the one with the least is nearest to the surface, and creases become edges). No
/// triangle turns over. \param changed per vertex whether it moved or is new since edges were flipped last: the search
/// begins near these; null: everywhere. \returns the number of flips.
int flip_edges(HalfEdgeMesh& mesh, const EdgeFlipOptions& options = {}, const std::vector<char>* changed = nullptr);

} // namespace recon
