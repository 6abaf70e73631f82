#pragma once

#include <recon/geometry.h>

namespace benchmarks
{

/// Normals by CGAL's principal components of the 30 nearest points, oriented along a minimum spanning tree.
recon::Vectors pca30_spanning_tree_normals(const recon::Points& points);

} // namespace benchmarks
