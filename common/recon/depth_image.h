#pragma once

#include <recon/geometry.h>

#include <optional>

namespace recon
{

/// Whether points are the pixels of a depth camera at the origin, as it delivers them: it looks along an axis, and seen
/// from there they lie on a grid, whatever their depths. All that such a camera saw faces it. Grids of a plane or a
/// terrain do not count: they are even by themselves, or reach over depths that differ by less than a quarter. A cloud
/// that was moved, thinned or merged looks like any other. \returns the camera's place, if so. Asks 1,000 points.
std::optional<Point> find_depth_camera(const Points& points);

} // namespace recon
