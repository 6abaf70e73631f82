#pragma once

#include <recon/geometry.h>
#include <recon/labelling/signed_graph.h>
#include <recon/triangulation/triangulation.h>

#include <vector>

namespace recon
{

/// The power crust as polygons: all faces of the power diagram between an inner and an outer cell (Mederos et al. 2005,
/// algorithm 4.1 step 6), turned outward. One vertex per regular cell with both labels, never welded by coordinates, so
/// it is a closed oriented 2-manifold by construction.
struct CrustPolygons
{
    Points vertices;
    std::vector<int> ball;        ///< Per vertex: a ball whose power cell has it as a corner.
    std::vector<int> first = {0}; ///< Corners of polygon p are corners[first[p]..first[p + 1]).
    std::vector<int> corners;     ///< Indices of vertices.
};

/// \param regular of the power diagram. \pre balls on its hull are outer. \returns no polygon if all labels are the
/// same.
CrustPolygons list_crust_polygons(const Triangulation& regular, const std::vector<Side>& labels, int threads = 1);

/// Polygons as fans of triangles, from the corner with the best worst one; their diagonals are faux edges.
TriangleMesh triangulate_polygons(const CrustPolygons& polygons, int threads = 1);

/// What triangles enclose, and their area.
struct Extent
{
    double volume = 0, area = 0;
    /// A triangle's part.
    void add(const TriangleMesh& mesh, const std::array<int, 3>& triangle);
};

/// Connected components of a mesh by shared vertices: per triangle its component, numbered in order of first triangle.
struct MeshComponents
{
    std::vector<int> of_triangle;
    std::vector<int> of_vertex; ///< -1 if it has no triangle.
    int count = 0;
};
MeshComponents find_components(const TriangleMesh& mesh);

/// Keeps the triangles for which keep[triangle] != 0, and only the vertices they use.
/// \returns for each vertex that is left its former index.
std::vector<int> keep_triangles(TriangleMesh& mesh, const std::vector<char>& keep);

/// The boundary loops of a manifold mesh: vertices in the direction in which triangles run along them, by their lowest.
std::vector<std::vector<int>> list_rims(const TriangleMesh& mesh);

/// What a manifold mesh without unused vertices is, topologically.
struct Topology
{
    int components = 0;
    int boundary_loops = 0;
    int euler_characteristic = 0; ///< V - E + F
    /// Summed over the components, each loop closed by a disc.
    int genus() const { return components - (euler_characteristic + boundary_loops) / 2; }
};
Topology measure_topology(const TriangleMesh& mesh);

/// The same of a mesh known to be closed, as a crust is: no edges need to be matched.
Topology measure_closed_topology(const TriangleMesh& mesh);

/// Volume that a closed mesh encloses [length^3], negative if it faces inward.
double measure_volume(const TriangleMesh& mesh);

/// Volume over half the area of a closed mesh that faces outward: the mean thickness of what is thin [length]; 0 of an
/// empty one.
double measure_thickness(const TriangleMesh& mesh);

/// Of a closed mesh in a unit frame. \throws AlgorithmFailure if it encloses no volume or faces inward: what vertices
/// that move onto their samples make of a crust where these are few and tell no inside.
void check_encloses_volume(const TriangleMesh& mesh);

} // namespace recon
