#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>
#include <recon/scan/viewpoint.h>

#include <vector>

namespace recon
{

/// Distance of each sample from the next line of its scan [length]: a scanner of few beams has its lines farther apart
/// than the samples of a line, the more so the more the surface turns away from it, as a floor does. Seen from where it
/// stood, the next line is the nearest sample across the direction to the nearest one; none is what lies so far behind
/// or before that the surface between would be seen at less than some three degrees.
/// \returns 0 where there is none, and everywhere if no place is known. \throws Cancelled.
std::vector<double> measure_line_spacing(const Points& samples, const Viewpoints& viewpoints, int threads = 1,
                                         const Progress& progress = {});

} // namespace recon
