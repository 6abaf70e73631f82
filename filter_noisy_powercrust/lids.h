#pragma once

#include <recon/geometry.h>
#include <recon/labelled_balls.h>

#include <vector>

namespace recon
{

/// Large inner balls that end at a lid: a face of the crust with no sample near, as over the mouth of a filled cup.
/// \param samples those that `labelled` was made of. \returns their numbers, ascending.
std::vector<int> list_balls_under_lids(const Points& samples, const LabelledBalls& labelled);

} // namespace recon
