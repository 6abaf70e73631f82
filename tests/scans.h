// What depth cameras and laser scanners see.
#pragma once

#include <recon/geometry.h>

#include <cstdint>

namespace shapes
{

/// One frame of a depth camera at the origin that looks along z, y down: a floor 0.6 below, a wall four away
/// and a ball between them. Depths are rounded to steps of `step` at a depth of 1 that grow with its square, up or down
/// by chance. \param columns of pixels; three quarters as many rows.
recon::OrientedSamples depth_frame(int columns, double step, std::uint64_t seed);

/// What a laser scanner, which turns about z, sees of a ball of radius 0.5 two away from the origin on a floor 1.5
/// below, up to four away or as far as the walls and the ceiling of a room. \param around rays of a turn; a third as
/// many over the other angle, 120 degrees. \param noise standard deviation of ranges, nearly Gaussian. \param place
/// where it stands.
recon::OrientedSamples laser_scan(int around, double noise, bool in_room, std::uint64_t seed,
                                  const recon::Point& place = recon::Point::Zero());

/// Such scans from several places, one after the other.
recon::OrientedSamples laser_scans(int around, double noise, bool in_room, std::uint64_t seed,
                                   const recon::Points& places);

} // namespace shapes
