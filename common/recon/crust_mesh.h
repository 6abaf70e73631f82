#pragma once

#include <recon/geometry.h>
#include <recon/power_diagram.h>
#include <recon/signed_labelling.h>
#include <recon/triangulation.h>

#include <vector>

namespace recon
{

/// The power crust: all faces of the power diagram between an inner and an outer cell (Mederos et al. 2005, algorithm 4.1
/// step 6), turned outward, polygons split into triangles. One vertex per regular cell with both labels, never welded by
/// coordinates, so it is a closed oriented 2-manifold by construction.
/// \pre balls on the hull are outer. `regular` is diagram.triangulation().
/// \returns an empty mesh if all labels are the same.
TriangleMesh extract_crust(const PowerDiagram& diagram, const Triangulation& regular, const std::vector<Ball>& balls,
                           const std::vector<Side>& labels);

/// Connected components of a mesh by shared vertices: per triangle its component, numbered in order of first triangle.
struct MeshComponents
{
    std::vector<int> of_triangle;
    int count = 0;
};
MeshComponents find_components(const TriangleMesh& mesh);

/// Keeps the component with the largest enclosed volume, and only the vertices it uses.
void keep_largest_component(TriangleMesh& mesh);

/// V - E + F of a closed triangle mesh without unused vertices.
int euler_characteristic(const TriangleMesh& closed_mesh);

} // namespace recon
