#pragma once

#include <recon/geometry.h>

namespace recon
{

/// Whether points are the readings of a scanner at the origin, in whatever order: seen from there nearly all are as far
/// from the nearest other, in angle, before and behind gaps in range. Samples of surfaces are not: where they are
/// farther off they look denser. Without gaps they may be, as bodies in polar coordinates are. Not told of readings
/// that were thinned, merged or moved; moved by a tenth of their ranges in no order they still pass. \pre finite.
bool is_scanner_at_origin(const Points& points);

} // namespace recon
