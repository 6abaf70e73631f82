#pragma once

#include "attempts.h"
#include "label_samples.h"

#include <recon/progress.h>

#include <optional>

namespace recon
{

struct BetweenSheets
{
    LabelledCloud attempt;
    bool has_lids; ///< What lids close may be hollows that were filled: of the first, too, unless that looked open.
};

/// Scans out of register: the labels of an attempt with more noise, if those of the first make a surface that weaves
/// between their sheets and this one does not, see weaving.h. \param first denoised attempt, whose noise was estimated.
/// \throws Cancelled.
std::optional<BetweenSheets> look_between_sheets(Attempts& attempts, LabelledCloud& first,
                                                 const Progress& progress = {});

} // namespace recon
