#pragma once

#include "nearest_table.h"

#include <recon/geometry.h>
#include <recon/progress.h>

#include <cmath>
#include <memory>
#include <vector>

namespace recon::pn
{

/// The samples that can take part in refinement, in the unit frame and in spatial order (which makes what follows
/// faster and mostly independent of the order of the input), and why the others cannot. Stays where it is: the search
/// refers to the samples.
struct UsableSamples
{
    UsableSamples() = default;
    UsableSamples(const UsableSamples&) = delete;
    UsableSamples& operator=(const UsableSamples&) = delete;

    OrientedSamples samples; ///< Unit normals.
    std::vector<int> input;  ///< Per sample its index in the input.
    /// Per sample: the first sample at the same position (a crease's first normal); itself mostly.
    std::vector<int> sharing;
    std::vector<int> beside;     ///< Per sample that was put in: another near it. Itself for those of the input.
    std::vector<char> is_crease; ///< Per sample: shares its position with another.
    /// Per sample: takes part as a neighbour only. Of samples that were put in: those all of whose parents do.
    std::vector<char> is_frozen;
    std::unique_ptr<BlockSearch> search; ///< Among the samples.
    NearestTable nearest;                ///< Of the samples.
    int duplicates = 0, without_normal = 0, isolated = 0;
};

/// Takes all but points without a normal, further points at one position whose normals differ by at most `crease_angle`
/// [radians] from one already there, and isolated points: those far from their neighbours compared with how far those
/// are from theirs. None is frozen. \param is_isolated per point, whether it is known to be isolated; empty: nothing is
/// known. \pre `usable` is empty.
void choose_usable_samples(const OrientedSamples& input, const std::vector<char>& is_isolated, const UnitFrame& frame,
                           double crease_angle, int threads, const Progress& progress, UsableSamples& usable);

/// Per sample the next at its position, itself if it is alone: rings.
std::vector<int> next_at_position(const UsableSamples& usable);

/// How far to look for k samples that lie `spacing` apart: a search without a guess has to make one first.
inline double likely_reach(double spacing, int k)
{
    return spacing * std::sqrt(double(k));
}

/// Makes search and table again after samples have been added or left out.
void update_nearest(UsableSamples& usable, int threads, const Progress& progress = {});

/// The same after samples have been added from `first_added` on; rows of the table that they do not touch are kept.
/// \returns per sample whether an added one is near enough to change its fan.
std::vector<char> add_to_nearest(UsableSamples& usable, std::size_t first_added, int threads,
                                 const Progress& progress = {});

} // namespace recon::pn
