#pragma once

#include "nearest_table.h"

#include <recon/geometry.h>
#include <recon/progress.h>

#include <vector>

namespace recon::pn
{

/// Turns unit normals that clearly contradict those of the nearest points on the same sheet, until none is left (at
/// most eight rounds). A cloud that is inside out as a whole stays so. \param is_frozen per sample: keeps its normal.
/// \returns the indices turned, ascending.
std::vector<int> turn_contradicting_normals(OrientedSamples& samples, const NearestTable& nearest,
                                            const std::vector<char>& is_frozen, int threads, const Progress& progress);

} // namespace recon::pn
