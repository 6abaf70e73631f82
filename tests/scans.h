// What depth cameras and laser scanners see.
#pragma once

#include <recon/geometry.h>

#include <cstdint>
#include <vector>

namespace shapes
{

/// One frame of a depth camera at the origin that looks along z, y down: a floor 0.6 below, a wall four away
/// and a ball between them. Depths are rounded to steps of `step` at a depth of 1 that grow with its square, up or down
/// by chance. \param columns of pixels; three quarters as many rows.
recon::OrientedSamples depth_frame(int columns, double step, std::uint64_t seed);

/// What a laser scanner, which turns about z, sees of a ball of radius 0.5 two away from the origin on a floor 1.5
/// below, up to four away or as far as the walls and the ceiling of a room. \param around rays of a turn; a third as
/// many over the other angle, 120 degrees. \param noise standard deviation of ranges, nearly Gaussian. \param place
/// where it stands. \param boxes that stand there, too.
recon::OrientedSamples laser_scan(int around, double noise, bool in_room, std::uint64_t seed,
                                  const recon::Point& place = recon::Point::Zero(),
                                  const std::vector<recon::Box>& boxes = {});

/// Those of a room by a scanner of few beams: of that scan's rows every `stride`-th. \param lowest, highest angle over
/// the horizon [degrees].
recon::OrientedSamples scan_by_beams(int around, int stride, double noise, std::uint64_t seed, double lowest = -60,
                                     double highest = 60);

/// Such scans from several places, one after the other.
recon::OrientedSamples laser_scans(int around, double noise, bool in_room, std::uint64_t seed,
                                   const recon::Points& places);

/// Views of a surface around the origin from so many sides, the points and normals that face each, every view moved
/// and turned by chance. \param kept share of the points in a view that sees them. \param off_by standard deviation of
/// a view's shift; its turn moves the farthest point as far.
recon::OrientedSamples views_out_of_register(const recon::OrientedSamples& surface, int views, double kept,
                                             double off_by, std::uint64_t seed);

/// Eight such views of a torus of radii 1 and 0.4, some 9,000 points, 0.12 out of register, with noise of 0.008.
recon::OrientedSamples torus_out_of_register(std::uint64_t seed);

} // namespace shapes
