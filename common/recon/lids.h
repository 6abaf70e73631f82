#pragma once

#include <recon/geometry.h>
#include <recon/labelled_balls.h>

#include <optional>
#include <vector>

namespace recon
{

/// Share of violated votes above which the walls of what is filled, seen with less noise, object to that: the mouth of
/// a cup may be open, though no sample is there to say so.
inline constexpr double objecting_votes = 0.02;
/// Share of them that open lids may leave: 0.07 to 0.55 where they closed cups, 0.98 where they were taken off mere
/// noise.
inline constexpr double clearly_fewer_votes = 0.65;

/// Whether an attempt with less noise says that no other will find walls: votes object to a scene as open as foliage
/// whatever its noise, not to filled walls (0.004 of them, 0.03 beside flat faces). \param violated_before, violated
/// shares of votes, of the attempt with the noise found and of this one.
inline bool is_open_at_any_noise(double violated_before, double violated)
{
    return violated_before > objecting_votes && violated > clearly_fewer_votes * violated_before;
}

/// What to tell users where lids were opened.
inline constexpr char opened_lids_text[] =
    "Walls are hardly thicker than the noise or the spacing. What they hold was left hollow, since the points object "
    "to filling it; the walls may have holes. Scan them more densely.";

/// Large inner balls that end at a lid: a face of the crust with no sample near, as over the mouth of a filled cup.
/// \param samples those that `labelled` was made of. \returns their numbers, ascending.
std::vector<int> list_balls_under_lids(const Points& samples, const LabelledBalls& labelled);

/// Labels with all lids open; none if there are none, or these do not violate clearly fewer votes. \param samples,
/// normals, options what `labelled` was made of, in which no balls were shared. \throws Cancelled.
std::optional<LabelledBalls> label_with_open_lids(const Points& samples, const Vectors& normals,
                                                  const LabelledBalls& labelled, BallLabellingOptions options,
                                                  PhaseTimes& times, const Progress& progress = {});

} // namespace recon
