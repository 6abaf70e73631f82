#pragma once

#include <recon/geometry.h>

#include <vector>

namespace recon
{

/// Greedy Poisson disks in the order given: each point that is in no disk yet stays and takes those within its radius.
/// \param radii per point, >= 0 [length]. \returns the indices that stay, ascending.
std::vector<int> keep_apart(const Points& points, const std::vector<double>& radii);

} // namespace recon
