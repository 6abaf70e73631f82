#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>

#include <cstddef>
#include <vector>

namespace recon
{

/// Consecutive points that one camera or scanner saw.
struct Scan
{
    std::size_t begin, end; ///< Of the points.
    Point place;            ///< From which they were seen.
};

/// Tells scans that follow each other, each in the order of its rays, from one another. Places are sought where
/// rays of ever smaller windows meet, and, if any is found, where points that none of them explains follow each other
/// most evenly. Points then go to the place from which they do that best, neighbours to the same one. Scans whose place
/// is not found are left out. \param gaps of the points, see ray_meeting.h. \pre finite; neighbours differ; near the
/// origin. \throws Cancelled.
std::vector<Scan> split_scans(const Points& points, const std::vector<std::size_t>& gaps, int threads = 1,
                              const Progress& progress = {});

} // namespace recon
