#pragma once

#include <recon/geometry.h>

#include <functional>
#include <vector>

namespace recon
{

/// Greedy Poisson disks in the order given: each point that is in no disk yet stays and takes those within its radius.
/// \param radii per point, >= 0 [length]. \param may_stay asked of each point that is in no disk; one that may not
/// takes none. All may, if empty. \returns the indices that stay, ascending.
std::vector<int> keep_apart(const Points& points, const std::vector<double>& radii,
                            const std::function<bool(int)>& may_stay = {});

} // namespace recon
