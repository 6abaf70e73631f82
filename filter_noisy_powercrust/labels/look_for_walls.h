#pragma once

#include "attempts.h"

namespace recon
{

/// A denoised cloud whose crust has lost walls, which read as noise: with balls by the spacing alone, with half the
/// noise and less, and, if it has no completed faces, with its lids open; or as it is. \throws Cancelled.
LabelledCloud look_for_walls(Attempts& attempts, LabelledCloud first, const Progress& progress);

} // namespace recon
