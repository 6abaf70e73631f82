#pragma once

#include <recon/mesh/crust_mesh.h>
#include <recon/mesh/half_edges.h>
#include <recon/search/nearest_samples.h>

#include <vector>

namespace recon
{

/// Edges shorter than this, relative to the scale, join the corners of one sample's cluster. At 0.1 the mesh gets no
/// better and bad clusters cost more than they save.
constexpr double cluster_length = 0.05;
/// The same where the nearest samples are known: corners of one sample's Voronoi cell join, so clusters do not grow
/// together.
constexpr double cluster_length_in_cell = 1;

/// Crust of which corners that crowd at one sample are one vertex.
struct WeldedCrust
{
    TriangleMesh mesh;
    HalfEdges half_edges;      ///< Of the mesh.
    std::vector<double> scale; ///< Per vertex, as given.
    std::vector<int> corner;   ///< Per vertex: the corner at which it lies.
    std::vector<int> merged;   ///< Per vertex: corners of the polygons that it stands for.
};

/// Makes one vertex of each cluster of neighbouring corners that crowd at one sample, where the surface stays what it
/// was, and triangulates the rest: at a clean sample some ten corners of the power diagram all but coincide. To take
/// them together before polygons become triangles is much faster than to collapse their edges one by one. A cluster is
/// welded if it is a disc (vertices - edges + faces = 1) and no edge gets more than two triangles by it, so the result
/// is a closed oriented manifold of the same topology. \param scale per corner, > 0. Edges shorter than cluster_length
/// of it are inside a cluster. \param nearest null, or per corner the nearest of the samples that the crust is to pass
/// through. Then a cluster is what hangs together of a sample's Voronoi cell, its vertex lies at the corner nearest to
/// the sample, and the mesh is little more than the Delaunay triangulation of the samples restricted to the crust.
WeldedCrust weld_clusters(const CrustPolygons& polygons, const std::vector<double>& scale,
                          const NearestSamples* nearest = nullptr, int threads = 1);

} // namespace recon
