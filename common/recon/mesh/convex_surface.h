#pragma once

#include <recon/errors.h>
#include <recon/geometry.h>

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace recon
{

/// The convex hull of points that lie on it.
struct ConvexSurface
{
    TriangleMesh mesh;       ///< Closed and outward; edges within flat faces are faux.
    std::vector<int> points; ///< Per vertex: index of the point.
    double spacing = 0;      ///< Median of the points' [length], see measure_spacing_at().
    /// Whether flat faces have points away from their rims. These may bound a bore; without them nothing else than the
    /// hull goes through all points.
    bool has_points_within_faces = false;
};

/// More points are sampled densely enough to tell by themselves [count].
inline constexpr std::size_t most_points_on_hull = 2'000;

/// The convex hull of points that all lie on it: corners of a box, two circles of a cylinder, a cone's circle and tip.
/// Few and even as these are, polar balls say little of them, or are all the same; the hull is what they bound. Points
/// within a millionth of the diagonal below it count. \returns it with all points on it for vertices, flat
/// faces' included, but those a little below. None if a point lies inside, if they do not span a volume, or are more
/// than most_points_on_hull. \pre finite.
std::optional<ConvexSurface> find_convex_surface(const Points& points);

/// What `reconstruct` finds, if that has handles or several parts, as plates with bores have; else the hull, since what
/// lies deeper than it has no points. \param hull none: there is no choice. \param take makes a result of the hull.
template <class Reconstruct, class Take>
auto hull_or(std::optional<ConvexSurface> hull, const Reconstruct& reconstruct, const Take& take)
    -> decltype(reconstruct())
{
    if (!hull)
        return reconstruct();
    if (hull->has_points_within_faces)
        try
        {
            auto found = reconstruct();
            constexpr int of_a_ball = 2;
            if (found.euler_characteristic != of_a_ball)
                return found;
        }
        catch (const AlgorithmFailure&)
        {
        }
    return take(std::move(*hull));
}

/// What either reconstruction says of a hull.
template <class Result>
Result result_of(ConvexSurface hull)
{
    Result result;
    result.mesh = std::move(hull.mesh);
    result.nearest_sample = std::move(hull.points);
    result.samples = int(result.mesh.vertices.size());
    result.components = 1;
    result.euler_characteristic = 2;
    result.is_convex = true;
    return result;
}

/// What to tell the user then.
inline constexpr char convex_text[] = "All points lie on their convex hull: the surface is that hull.";

} // namespace recon
