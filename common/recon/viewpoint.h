#pragma once

#include <recon/geometry.h>

#include <optional>

namespace recon
{

/// The place from which points were seen, told by the order in which they come, along rows or columns of rays. Where
/// what is near ends, the next point lies far behind it: a ray goes through where the near side would have gone on, and
/// through that point. Rays of all such gaps meet where the scanner is, and from there every point is as far from the
/// next, in angle, as that from the one after it. Noise along the rays changes neither. None if the points come in
/// another order, were moved across their rays, or seen from several places. \pre finite. Serial: one look at each
/// point, and some more at the gaps.
std::optional<Point> find_scan_origin(const Points& points);

/// Place of the camera or scanner that all points face: the origin, if they are its pixels as it delivers them
/// (depth_image.h), or the one that their order tells. \param sorted the same in another order, where the former must
/// not hang on how they come. \pre finite.
std::optional<Point> find_viewpoint(const Points& points, const Points& sorted);
std::optional<Point> find_viewpoint(const Points& points);

} // namespace recon
