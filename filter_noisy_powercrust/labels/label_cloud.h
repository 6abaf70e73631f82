#pragma once

#include "label_samples.h"
#include "prepare_samples.h"

#include <recon/labelling/labelled_balls.h>
#include <recon/progress.h>

#include <cstddef>
#include <string>

namespace recon
{

/// Prepares the samples and labels them, see label_samples(). A result that the points contradict has rivals: of a
/// denoised cloud whose crust weaves between scans out of register, the same with more noise; of one whose crust has
/// lost walls that read as noise, the same with half the noise and less, and, if it has no completed faces, with its
/// lids open; of a clean cloud whose crust misses points (an open scan that outer balls flood, coarse limbs), the
/// denoised one; of lace, the denoised cloud with backs behind the sheets. \param labelling with lengths in input
/// units.
LabelledCloud label_cloud(const Points& points, const SamplePreparationOptions& options,
                          const BallLabellingOptions& labelling, PhaseTimes& times, const Progress& progress = {});

/// What to tell users of sheets without an inside, empty if there are none. \param share of the samples in them, in a
/// crust with handles [0..1]. \param backs samples put behind them [count]. \param denoise, points what label_cloud()
/// was asked, on which it depends whether a back was tried.
std::string describe_lost_sheets(double share, int backs, Denoise denoise, std::size_t points);

} // namespace recon
