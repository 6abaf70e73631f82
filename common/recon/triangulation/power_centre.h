#pragma once

#include <recon/geometry.h>

#include <array>

namespace recon
{

/// The point of equal power |x - p|^2 - w to four weighted points: a vertex of the power diagram, with equal weights
/// the circumcentre. In double where that satisfies the four equations to a relative 1e-8, else in 113 bits, else in
/// exact rationals: on flat cells, of which clean scans and CAD shapes are full, double alone errs by any amount. \pre
/// the points span a volume (cells of a triangulation do, however flat).
Point find_power_centre(const std::array<Point, 4>& points, const std::array<double, 4>& weights);

} // namespace recon
