#pragma once

#include <recon/geometry.h>

#include <cstddef>

namespace recon
{

/// Relative difference of the angles, as seen from a place, to the point before the i-th and the one after it [0..1].
/// \pre both exist.
double measure_deviation(const Points& points, std::size_t i, const Point& place);

/// How points follow each other as seen from a place.
struct Evenness
{
    double share = 0;     ///< Of points as far, in angle, from the next as that from the one after it, within a fifth.
    double deviation = 1; ///< Median relative difference of these angles,
    double of_most = 1;   ///< and the upper quartile.

    /// Whether they are rows of rays from there.
    bool is_of_rows() const;
    /// Whether three quarters follow each other as only rays from there do, wherever others saw nothing.
    bool is_exact() const;
};
Evenness measure_evenness(const Points& points, const Point& place);

/// The place near `place` from which points follow each other most evenly: with noise along the rays it is told far
/// more sharply than by rays that meet. Gauss-Newton steps on the relative differences, large ones weighed as Cauchy's.
Point find_most_even(const Points& points, const Point& place);

/// Whether what is seen next to each other lies at one distance, but for gaps; else there is something in between, or
/// leaves and clutter, among which only exact rows tell a place.
bool sees_all(const Points& points, const Point& place);

} // namespace recon
