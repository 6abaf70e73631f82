#pragma once

#include <recon/geometry.h>

#include <array>
#include <vector>

namespace recon::pn
{

/// Samples put where the input has none, before the first step: onto creases, into holes, into folds.
struct AddedSamples
{
    OrientedSamples samples;
    std::vector<std::array<int, 3>>
        parents; ///< Usable samples, or (from their number on) samples added before this one.
};

} // namespace recon::pn
