#pragma once

#include <recon/crust_mesh.h>
#include <recon/half_edges.h>

#include <vector>

namespace recon
{

/// Edges shorter than this, relative to the scale, join the corners of one sample's cluster. At 0.1 the mesh gets no better and
/// bad clusters cost more than they save.
constexpr double cluster_length = 0.05;

/// Crust of which corners that crowd at one sample are one vertex.
struct WeldedCrust
{
    TriangleMesh mesh;
    HalfEdges half_edges;      ///< Of the mesh.
    std::vector<double> scale; ///< Per vertex, as given.
    std::vector<int> merged;   ///< Per vertex: corners of the polygons that it stands for.
};

/// Makes one vertex of each cluster of neighbouring corners that crowd at one sample, where the surface stays what it was, and
/// triangulates the rest: at a clean sample some ten corners of the power diagram all but coincide. To take them together before polygons
/// become triangles is much faster than to collapse their edges one by one.
/// A cluster is welded if it is a disc (vertices - edges + faces = 1) and no edge gets more than two triangles by it, so the
/// result is a closed oriented manifold of the same topology.
/// \param scale per corner, > 0. Edges shorter than cluster_length of it are inside a cluster.
WeldedCrust weld_clusters(const CrustPolygons& polygons, const std::vector<double>& scale, int threads = 1);

} // namespace recon
