#pragma once

#include <recon/geometry.h>

#include <cstddef>
#include <optional>
#include <vector>

namespace recon
{

/// Angle between two points as seen from a place [rad].
double angle_at(const Point& place, const Point& a, const Point& b);

/// Where points that come along rows of rays jump from what is near to what lies far behind, or back: indices of those
/// before the jump, ascending, each at least 1 and at most the number of points less 3.
std::vector<std::size_t> find_gaps(const Points& points);

/// Whether a place sees both sides of a gap next to each other.
bool sees_across(const Point& place, const Points& points, std::size_t gap);

/// Where the rays through both sides of gaps meet.
struct Meeting
{
    Point place;
    std::size_t asked = 0; ///< Gaps [count].
    std::size_t rays = 0;  ///< Those of them that are seen from there [count].
    double spread = 0;     ///< Least by largest eigenvalue of the rays' normal equations, 0 of parallel ones [0..1].

    /// Whether the rays come from directions enough to tell the place.
    bool is_sharp() const;
    /// Of the gaps those that are seen [0..1].
    double share() const { return double(rays) / double(asked); }
    /// Whether so many are seen from there as from a camera or scanner.
    bool has_many() const;
};

/// Pairs of rays that are tried, and gaps that have a say in which is the best [count]: the former must be several
/// times the inverse square of the share that meets.
struct MeetingTrials
{
    std::size_t pairs = 400, asked = 200;
};

/// The place at which most of the gaps' rays meet: guessed from pairs of them, then the nearest to all that meet about
/// there. None of no gaps, or of parallel rays.
std::optional<Meeting> find_meeting(const Points& points, const std::vector<std::size_t>& gaps,
                                    const MeetingTrials& trials = {});

} // namespace recon
