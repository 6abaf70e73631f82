#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>
#include <recon/search/block_search.h>

#include <vector>

namespace recon
{

/// With those scattered through space that are company of each other: as far from their neighbours as the known ones
/// around, and on no sheet (sparse_parts.h). \param points in spatial order. \param search of them. \param known
/// indices of outliers, ascending. \throws Cancelled. \returns indices of both, ascending.
std::vector<int> with_scattered_points(const Points& points, const BlockSearch& search, std::vector<int> known,
                                       int threads, const Progress& progress = {});

} // namespace recon
