#pragma once

#include "nearest_table.h"

#include <recon/geometry.h>
#include <recon/progress.h>

#include <string>
#include <vector>

namespace recon::pn
{

/// The samples that can take part in refinement, in the unit frame, and why the others cannot.
struct UsableSamples
{
    OrientedSamples samples; ///< Unit normals.
    std::vector<int> input;  ///< Per sample its index in the input.
    std::vector<int>
        sharing; ///< Per sample: the first sample at the same position (a crease's first normal); itself mostly.
    std::vector<char> is_crease; ///< Per sample: shares its position with another.
    NearestTable nearest;        ///< Of the samples.
    int duplicates = 0, without_normal = 0, isolated = 0;
};

/// Leaves out points without a normal, further points at one position whose normals differ by at most `crease_angle`
/// [radians] from one already there, and isolated points: those far from their neighbours compared with how far those
/// are from theirs.
UsableSamples choose_usable_samples(const OrientedSamples& input, const UnitFrame& frame, double crease_angle,
                                    int threads, const Progress& progress);

} // namespace recon::pn
