#pragma once

#include <recon/geometry.h>

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

/// Solids whose medial axis is known, for tests and benchmarks of the power shape.
namespace shapes
{

struct MedialShape
{
    std::string name;
    recon::Points points; ///< Area-uniform random samples of its surface.
    double spacing;       ///< Root of the area per sample.
    std::function<double(const recon::Point&)> distance_to_axis;
    recon::Points on_axis; ///< Points all over the axis.

    /// One sample a spot, or each sample and four copies; noise in spacings.
    recon::Points noisy(double noise, bool with_copies, std::uint64_t seed) const;
};

/// Torus 3, 1: its axis is a circle.
MedialShape medial_torus(int n, std::uint64_t seed);
/// Capsule of radius 1: a segment of length 4.
MedialShape medial_capsule(int n, std::uint64_t seed);
/// Box 4 x 3 x 2: sheets, of which twelve end at its edges.
MedialShape medial_box(int n, std::uint64_t seed);

/// How far a medial axis lies from the true one [spacings]: one way the farthest that it strays, the other way the
/// farthest place of the true one that it does not reach. The larger is Hausdorff's distance.
struct MedialError
{
    double strays = 0, unreached = 0;
    double hausdorff() const { return strays > unreached ? strays : unreached; }
};

/// \param centres, edges, triangles of a power shape; centres of edges and triangles count as well.
MedialError measure_medial_error(const MedialShape& shape, const recon::Points& centres,
                                 const std::vector<std::array<int, 2>>& edges,
                                 const std::vector<std::array<int, 3>>& triangles);

} // namespace shapes
