#pragma once

#include <recon/geometry.h>
#include <recon/labelling/labelled_balls.h>

#include <optional>
#include <string>
#include <vector>

namespace recon
{

/// Share of violated votes above which the walls of what is filled, seen with less noise, object to that: the mouth of
/// a cup may be open, though no sample is there to say so.
inline constexpr double objecting_votes = 0.02;
/// Share of them that open lids may leave: 0.07 to 0.55 where they closed cups, 0.98 where they were taken off mere
/// noise.
inline constexpr double clearly_fewer_votes = 0.65;

/// How an attempt stands to its points.
struct PointsAgainst
{
    double missed;   ///< Share of points missed, see Mismatch [0..1].
    double violated; ///< Share of violated votes [0..1].
};

/// Whether an attempt with less noise tells that no other will find walls, unless open lids do in this one, as in
/// pipes, which are told from foliage by nothing else. Either votes object to a scene as open as foliage whatever its
/// noise: it misses 0.086 of the points and more, or nearly as many as before while no more votes object (1.08 times),
/// where walls are found in the end 0.031, or more votes object to what is seen of them by then (1.17 times and more).
/// Or the noise is of the spacing and misses points by itself: half of it leaves 0.69 to 0.72 of those, 0.04 to 0.51
/// where walls are found in the end.
inline bool finds_no_walls(const PointsAgainst& before, const PointsAgainst& with_less)
{
    const bool is_open =
        before.violated > objecting_votes && with_less.violated > clearly_fewer_votes * before.violated;
    const bool are_left = with_less.missed > 0.6 * before.missed;
    const bool objects_as_before = with_less.violated < 1.12 * before.violated;
    return (is_open && ((are_left && objects_as_before) || with_less.missed > 0.05)) ||
           (before.missed > 0.25 && are_left);
}

/// What to tell users of walls that may have holes: lids were opened, or they were found with less noise and too many
/// votes are violated. Empty: nothing.
std::string describe_thin_walls(bool opened, bool found_with_less_noise, double violated_votes);

/// Large inner balls that end at a lid: a face of the crust with no sample near, as over the mouth of a filled cup.
/// \param samples those that `labelled` was made of. \returns their numbers, ascending.
std::vector<int> list_balls_under_lids(const Points& samples, const LabelledBalls& labelled);

/// Labels with all lids open; none if there are none, these do not violate clearly fewer votes, or balls were shared:
/// those of the next run have other numbers. \param samples, normals, options what `labelled` was made of.
/// \throws Cancelled.
std::optional<LabelledBalls> label_with_open_lids(const Points& samples, const Vectors& normals,
                                                  const LabelledBalls& labelled, BallLabellingOptions options,
                                                  PhaseTimes& times, const Progress& progress = {});

} // namespace recon
