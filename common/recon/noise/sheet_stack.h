#pragma once

#include <recon/geometry.h>

#include <optional>
#include <vector>

namespace recon
{

/// Neighbours beyond this number do not count in find_stacked_sheet().
constexpr int most_around_stack = 200;

/// One of the parallel sheets around a place.
struct StackedSheet
{
    double sigma;             ///< Noise: root mean square distance from its quadric [length].
    double density;           ///< Points per area of this sheet alone [1 / length^2].
    std::vector<int> members; ///< Which of the neighbours lie in it, nearest first.
};

/// The sheet through a point among others that lie beside it, as fins of a heat sink or the decks of a building do; a
/// stack of them looks like a thick layer of noise at every scale. The planes through the point and two of its nearest
/// are tried, the one that holds most neighbours is bent to a quadric. It is a sheet of a stack if the gap beside it is
/// nearly empty and what lies beyond is as much as a sheet. \param neighbours of `centre`, nearest first, itself
/// included. \param squared their squared distances [length^2].
std::optional<StackedSheet> find_stacked_sheet(const Points& points, const Point& centre, const int* neighbours,
                                               const double* squared, int count);

} // namespace recon
