#pragma once

#include "tests/checks.h"

#include <recon/geometry.h>

#include <string>
#include <vector>

namespace benchmarks
{

/// Reads the vertices, triangles and, where it has them, normals of a PLY file (ASCII or binary little endian).
struct Model
{
    recon::TriangleMesh mesh;
    recon::Vectors normals; ///< Empty, or one per vertex.
    double diagonal = 0;
    int genus = 0;     ///< With every hole closed by a fan around its centroid; 0 for a point cloud.
    double volume = 0; ///< Likewise.
};
Model load_model(const std::string& path);
void save_ply(const std::string& path, const recon::TriangleMesh& mesh);
void save_ply(const std::string& path, const recon::Points& points, const recon::Vectors& normals = {});

/// Means of the triangles' normals at each vertex, weighted by angle; not of unit length.
recon::Vectors vertex_normals(const recon::TriangleMesh& mesh);

/// What the tables call right: one component of that genus, closed, manifold, outward, its volume within 3 % of the
/// true one. \param volume over the true one.
bool is_right(const checks::MeshReport& report, int genus, double volume);

/// The cloud of one cell: each vertex plus 4 Gaussian copies at sigma = percent / 100 x diagonal; the vertices alone at
/// 0.
recon::Points noisy_cloud(const Model& model, double percent, unsigned seed);

/// The points and a share of uniform ones in a box 10 % larger; these outliers come last.
recon::Points with_outliers(recon::Points points, double share, unsigned seed);

/// Models of the grids, as file names without ".ply".
extern const std::vector<std::string> grid_a, grid_b, grid_c;

/// The words of an argument like "0.1,0.2".
std::vector<std::string> split_at_commas(const std::string& list);

/// Seconds of CPU of all threads of this process so far: what is compared when a machine is shared.
double cpu_seconds();

} // namespace benchmarks
