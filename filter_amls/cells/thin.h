#pragma once

#include <recon/geometry.h>

#include <vector>

namespace recon
{

/// Greedy Poisson-disk subset in a fixed random order: no two chosen points with normals in one half space are closer
/// than the radius of the one chosen first. Points whose normals disagree do not see each other, so the two sides of a
/// wall stay. Strays, whose disk holds far fewer points than expected and than the disks around, are not chosen. The
/// choice does not depend on the number of threads. \param radii per point, > 0 [length]. \param expected points in the
/// disk of that radius, per point [count].
/// \returns ascending indices.
std::vector<int> thin_to_poisson_disks(const Points& points, const Vectors& normals, const std::vector<double>& radii,
                                       const std::vector<double>& expected, int threads);

} // namespace recon
