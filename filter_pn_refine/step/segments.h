#pragma once

#include "filter_pn_refine/samples/usable_samples.h"
#include "initial_fans.h"
#include "level.h"

#include <array>
#include <cstdint>
#include <vector>

namespace recon::pn
{

/// Part of a rim (one normal at each end) or of a crease (two), refined along its own curve (section 6). Ends are ids.
struct Segment
{
    std::array<int, 2> a, b; ///< Per side; rims use the first only.
    int sides = 1;
};

/// Pairs of rim points that follow each other on both their fans and are not far apart against the usual spacing.
std::vector<Segment> find_boundary_segments(const UsableSamples& usable, const InitialFans& fans,
                                            const std::vector<float>& spacing, double boundary_angle);

/// Pairs of crease positions that are neighbours on two sides: straight on, not across, and not where a face has ended.
/// \param sides from sides_of_faces().
std::vector<Segment> find_crease_segments(const UsableSamples& usable, const InitialFans& fans,
                                          const std::vector<std::uint32_t>& sides, double crease_angle);

/// Where the points inserted on a segment went: leaf and index there, per side, at one third and at two.
struct InsertedThirds
{
    std::array<std::array<std::array<int, 2>, 2>, 2> place; ///< [third][side] = {leaf, index}
    bool is_done = false;
};

/// Inserts two points (on creases two pairs) on each segment whose ends are still refined and which is not short
/// against the spacing around it, at the thirds of its cubic curve, as children of the leaves that hold its ends.
/// \param spacing_ratio by which points have come nearer to each other since the start.
std::vector<InsertedThirds> insert_thirds(const std::vector<Segment>& segments, const Level& level, float spacing_ratio,
                                          int ids, int threads, std::vector<LeafChildren>& children,
                                          std::vector<WorkPoint>& made);

/// Replaces every segment that has been divided by its three parts. The child k of leaf i has the id
/// first_id + first[i] + k.
std::vector<Segment> divide_segments(const std::vector<Segment>& segments, const std::vector<InsertedThirds>& inserted,
                                     const std::vector<int>& first, int first_id);

} // namespace recon::pn
