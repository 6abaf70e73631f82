#pragma once

#include <recon/geometry.h>
#include <recon/triangulation/power_diagram.h>
#include <recon/triangulation/triangulation.h>

#include <array>
#include <functional>
#include <vector>

namespace recon
{

/// The poles of each sample (Amenta and Bern 1999; Mederos et al. 2005, algorithm 4.1 step 2): the two Voronoi vertices
/// of its cell farthest from it, one on either side. -1: there is none.
struct Poles
{
    static constexpr int none = -1;
    std::vector<std::array<int, 2>> cells; ///< Per sample: Delaunay cells dual to the first and the second pole.
    std::vector<std::array<int, 2>> slant; ///< Per sample: those of the slant poles beside them. May be empty.
};

/// First pole: the farthest Voronoi vertex. Second: the farthest in the half space away from the first. `threads` >= 1
/// here and below; the result does not depend on it.
Poles find_poles(const Triangulation& delaunay, const Points& samples, int threads = 1);

/// With normals: first pole = farthest Voronoi vertex on the outer side, second = farthest on the inner side.
/// Samples beyond the normals (the corners of the box) get poles as without.
Poles find_poles_along_normals(const Triangulation& delaunay, const Points& samples, const Vectors& normals,
                               int threads = 1);

/// Finds the slant poles: on either side the farthest Voronoi vertex 45 degrees or more from the pole and at least 0.7
/// times as far. A well sampled cell is slender and has none. Where samples lie in rings around a limb, or on the rims
/// of bare flats, a cell reaches past its ring to both sides, and the pole alone leaves one of them without a ball.
void find_slant_poles(const Triangulation& delaunay, const Points& samples, Poles& poles, int threads = 1);

/// Lets samples share poles: up to four take the one Voronoi vertex that their cells have in common, if for each of
/// them it is at least 0.7 times as far as its own pole and within 18 degrees of it. Four of ten polar balls are left,
/// and every sample is touched from as many sides as before; but the crust is a little coarser, for one that goes
/// through the samples afterwards. Samples with slant poles keep their own.
void share_poles(const Triangulation& delaunay, const Points& samples, Poles& poles, int threads = 1);

/// Polar balls that were kept. Many samples share one ball.
struct PolarBalls
{
    std::vector<Ball> balls;
    std::vector<std::array<int, 4>> touched;   ///< Per ball: the four samples on its boundary.
    std::vector<std::array<int, 2>> of_sample; ///< Per sample: its kept balls (first, second pole) or Poles::none.
    std::vector<std::array<int, 2>> slant_of_sample; ///< The same of its slant poles.
    std::vector<char> is_outside;                    ///< Per ball: polar ball of a corner of the bounding box.
};

/// Corners of the box that keeps every Voronoi cell of the samples bounded, +-2.5 in every coordinate (UnitFrame).
/// Samples come first, then these 8.
constexpr int box_corner_count = 8;
void append_box_corners(Points& samples);

/// Keeps the polar balls for which keep(radius, samples touched) holds, and those of the box corners (the last
/// `box_corner_count` samples).
PolarBalls keep_polar_balls(const Triangulation& delaunay, const Points& samples, const Poles& poles,
                            const std::function<bool(double radius, const std::array<int, 4>& touched)>& keep);

/// How far the normals of the samples on a ball's boundary point at its centre: the mean cosine, 1 = outside,
/// -1 = inside, 0 = no normals. \param normals of the first samples, of unit length; may be empty.
double measure_outwardness(const PolarBalls& balls, int ball, const Points& samples, const Vectors& normals);

} // namespace recon
