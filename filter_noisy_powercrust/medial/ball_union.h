#pragma once

#include <recon/progress.h>
#include <recon/triangulation/power_diagram.h>
#include <recon/triangulation/triangulation.h>

#include <vector>

namespace recon
{

struct UnionMeasure
{
    double volume = 0, area = 0; ///< [length^3], [length^2]
};

/// Volume and area of the union of the balls with is_member, by the divergence theorem over directions of a Fibonacci
/// sphere: a point of a ball's sphere is on the union's boundary if no neighbouring member holds it. Each ball turns
/// the directions its own way: the same ones would all miss, or all meet, the small caps along a flat face. What is
/// left of many spheres does not quite close, so positions count from the middle of each component: a far one must not
/// weigh. \pre `regular` is the triangulation of the members, and perhaps others that are no member. \throws Cancelled.
UnionMeasure measure_union(const Triangulation& regular, const std::vector<Ball>& balls,
                           const std::vector<char>& is_member, int threads, const Progress& progress = {});

} // namespace recon
