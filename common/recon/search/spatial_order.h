#pragma once

#include <recon/geometry.h>

#include <vector>

namespace recon
{

/// Indices of the distinct points, sorted along a Z-order curve through the bounding box; of equal points the first.
/// Neighbours in space are mostly neighbours in memory then, every k-th one is an even sample of the cloud, and an
/// algorithm that works in this order does not depend on the order of its input.
/// \pre points are finite. \param threads [count], >= 1; the result does not depend on it.
struct SpatialOrder
{
    std::vector<int> order;          ///< Input index of each distinct point.
    std::vector<int> representative; ///< Per input point: its position in `order`, equal points share one.
};
SpatialOrder order_spatially(const Points& points, int threads = 1);

/// Extent of a spot, whose points count as one [diagonals of the cloud].
inline constexpr double spot_size = 1e-6;

/// The same for points as they came in: those within a millionth of the cloud's extent of each other, with nothing else
/// within a hundred times that, count as equal, unless they are a twentieth of all or more than a thousand. The
/// meridians of a parametrised sphere end in a hundred points some 1e-16 or 1e-8 apart, and spacings measured there
/// would outweigh all others. Where a twentieth of a thousand points and more have twins, as of one scan twice, written
/// with other digits, these count as equal up to a ten-thousandth, if hardly any are five times as far from each other.
SpatialOrder order_input(const Points& points, int threads = 1);

/// The order that order_input() gives the points without some of them, so that nothing tells the rest from a cloud that
/// never had these. \param left_out positions in `order`, ascending. \param order of `points`.
std::vector<int> order_without(const std::vector<int>& left_out, const std::vector<int>& order, const Points& points);

} // namespace recon
