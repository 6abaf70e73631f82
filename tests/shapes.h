#pragma once

#include <recon/geometry.h>

#include <cstdint>
#include <functional>
#include <random>

/// Point clouds on surfaces whose distance, normal and genus are known exactly. The same seed gives the same points.
namespace shapes
{

using Random = std::mt19937_64;
/// From 0 to below 1.
double uniform(Random& random);
/// Of two and of three draws. Compilers evaluate arguments in an order of their own, so Vector(draw(), draw(), draw())
/// is another vector on another machine.
template <class Draw>
Eigen::Vector2d draw_pair(Draw&& draw)
{
    const double y = draw(), x = draw();
    return {x, y};
}
template <class Draw>
recon::Vector draw_vector(Draw&& draw)
{
    const double z = draw(), y = draw(), x = draw();
    return {x, y, z};
}

/// Keeps a random order's points that are at least 0.8 spacings from all kept ones: even samples without a lattice.
class PoissonDisks
{
public:
    PoissonDisks(double spacing, std::uint64_t seed) : spacing_(spacing), random_(seed) {}
    double uniform() { return shapes::uniform(random_); }
    /// Appends what is free among `tries` points from `draw`; points that are there already do not count.
    void fill(const std::function<recon::Point()>& draw, int tries, recon::Points& points);

private:
    double spacing_;
    Random random_;
};

/// Area-uniform random points with outward normals.
recon::OrientedSamples sphere(int n, double radius, std::uint64_t seed);
/// What of it lies below `z`.
recon::Points sphere_below(double z, int n, double radius, std::uint64_t seed);
/// Torus around the z axis: tube `minor` around the circle of radius `major`.
recon::OrientedSamples torus(int n, double major, double minor, std::uint64_t seed);
/// The same in rings of points, as vertices of a mesh lie: about one a unit of area.
recon::OrientedSamples torus_of_rings(double major, double minor);
/// The same by PoissonDisks of spacing 1.
recon::Points even_torus(double major, double minor, std::uint64_t seed);
/// Axis-aligned box centred at the origin.
recon::OrientedSamples box(int n, const recon::Vector& sides, std::uint64_t seed);
/// Random points anywhere in such a box.
recon::Points scattered(int n, const recon::Vector& sides, std::uint64_t seed);
/// Ellipsoid with the given half axes (area-uniform by rejection).
recon::OrientedSamples ellipsoid(int n, const recon::Vector& half_axes, std::uint64_t seed);
/// Cylinder of half length `half_length` along z with hemispherical caps.
recon::OrientedSamples capsule(int n, double radius, double half_length, std::uint64_t seed);
/// Both sides and the ends of an open tube around the z axis.
recon::OrientedSamples tube(int n, double radius, double wall, double half_length, std::uint64_t seed);
/// A tube whose walls are 1.3 spacings thick, so that neighbourhoods mix their sides: 4000 samples.
inline constexpr double thin_tube_spacing = 0.095;
recon::OrientedSamples thin_tube(std::uint64_t seed);
/// Such a tube of radius 1 and length 3 with walls of some spacings: 4000 samples.
struct Pipe
{
    recon::OrientedSamples samples;
    recon::Points noisy;
    double volume = 0; ///< Of the walls.
};
/// \param wall, noise [spacings]
Pipe pipe(double wall, double noise, std::uint64_t seed);
/// The two faces of a square plate of `side` spacings, one sample a unit of area, jittered within the faces.
recon::Points thin_plate(int side, double thickness, std::uint64_t seed);
/// Such faces one above the other; a plate is two of them.
recon::Points stack_of_sheets(int sheets, int side, double gap, std::uint64_t seed);
/// A plate of side x side x thickness around the origin, with bores of one diameter along z at `bores`, their walls
/// included: PoissonDisks of spacing 1.
recon::Points plate(double side, double thickness, const recon::Points& bores, double diameter, std::uint64_t seed);
/// A plate of side 30 with 3 x 3 bores, 9 apart.
recon::Points bored_plate(double thickness, double diameter, std::uint64_t seed);

/// A ball of radius 8 with twelve blunt spikes 7 long, at their base `width` wide: random points, one a unit of
/// area.
recon::Points spiky_ball(double width, std::uint64_t seed);

/// A ball of radius 1, 6,000 random points, and six hairs 1 long, of 30 points each, that no surface can follow.
recon::Points ball_with_hairs(std::uint64_t seed);

/// A ball of radius 40 and, the last points, a fin of 18 x 12 that stands on it along x and of which one side was seen:
/// random points, one a unit of area, outward normals.
struct FinnedBall
{
    recon::OrientedSamples samples;
    int fin = 0; ///< Samples on the fin, the last [count].

    recon::Points fin_points() const { return {samples.points.end() - fin, samples.points.end()}; }
};
FinnedBall finned_ball(std::uint64_t seed);

/// A ball of radius 12 that touches a square ground (z = 0) of side 100, not in its middle, seen from above: one sample
/// a unit of area, jittered on the ground.
recon::Points ball_on_a_ground(std::uint64_t seed);

/// A square floor (z = 0) of side 100 and, 20 above it, a table's top of 36 x 28, seen from straight above: one sample
/// a unit of area, jittered, none in the table's shadow; all face up.
recon::OrientedSamples table_over_a_floor(std::uint64_t seed);

/// A closed ball, one sample a unit of area, and behind its samples those of the same floor, whole, facing up.
recon::OrientedSamples ball_apart_from_a_floor(const recon::Point& centre, double radius, std::uint64_t seed);

/// Floor and wall of a cup of radius 1 along z, whose rim at `height` goes up and down by `wave` three times around.
recon::Points cup_with_wavy_rim(int n, double height, double wave, std::uint64_t seed);

/// A surface over the unit square.
using SheetMap = std::function<recon::Point(double, double)>;
/// Area-uniform random points of an open sheet with normals of one side.
recon::OrientedSamples sheet(int n, const SheetMap& at, std::uint64_t seed);
/// Two arcs of 270 degrees and radius 0.4 that bend to either side, 1.6 wide.
recon::Point s_sheet(double u, double v);
/// A spiral of 1.5 turns, 0.52 apart, 2.4 in diameter and 1.6 wide.
recon::Point rolled_sheet(double u, double v);
/// A helicoid of 270 degrees around the z axis, radii 0.2 to 1, that rises by 1.2.
recon::Point winding_sheet(double u, double v);
/// A terrain of side 2, z = height sin(along_x x) cos(along_y y), facing up.
SheetMap wavy_terrain(double height, double along_x, double along_y);

/// Distance to the surface, >= 0.
double distance_to_sphere(const recon::Point& p, double radius);
double distance_to_torus(const recon::Point& p, double major, double minor);
double distance_to_box(const recon::Point& p, const recon::Vector& sides);
double distance_to_capsule(const recon::Point& p, double radius, double half_length);

/// Root mean square of the points' distances.
double rms(const recon::Points& points, const std::function<double(const recon::Point&)>& distance);

/// Each point moved by isotropic Gaussian noise of standard deviation `sigma` per coordinate.
recon::Points with_noise(const recon::Points& points, double sigma, std::uint64_t seed);
/// The same of those points only for which it is asked, in turn.
recon::Points with_noise_where(const std::function<bool(const recon::Point&)>& is_noisy, const recon::Points& points,
                               double sigma, std::uint64_t seed);
/// The same of such a share of the points, anywhere among the others.
recon::Points with_noisy_share(double share, const recon::Points& points, double sigma, std::uint64_t seed);
/// The same of those points only whose x is larger than `x`.
recon::Points with_noise_beyond(double x, const recon::Points& points, double sigma, std::uint64_t seed);
/// So many noisy ones of each, of the seeds `seed`, `seed` + 1 and so on.
recon::Points noisy_copies(const recon::Points& points, double sigma, int copies, std::uint64_t seed);
/// Every point, and `copies` Gaussian copies of it: the clouds of Mederos et al. and of our benchmarks.
recon::Points with_noisy_copies(const recon::Points& points, double sigma, int copies, std::uint64_t seed);
/// Copies of each sample, moved along its normal alone, with that.
recon::OrientedSamples copies_along_normals(const recon::OrientedSamples& samples, double sigma, int copies,
                                            std::uint64_t seed);

/// A square cup with one sample a unit of area.
struct Cup
{
    explicit Cup(double wall, double side = 16);

    double volume; ///< Of its walls and its ground.
    recon::Points points;
    /// Without those of the inside up to that height over the ground's underside: no view reached it.
    recon::Points seen_above(double height) const;

private:
    double wall_, side_;
};

/// What a range scanner sees of a union of boxes from `views` directions spread over the sphere, free of noise: the
/// first hit of each pixel's ray, `pixels` across the bounding sphere.
recon::Points scan_boxes(const std::vector<recon::Box>& boxes, int views, int pixels);

/// Fins on a base, with one sample a unit of area: all measures in spacings.
struct HeatSink
{
    HeatSink(int fins, double wall, double gap, double height, double length, double base, std::uint64_t seed = 3);

    double volume;
    recon::Points points;
};

} // namespace shapes
