#pragma once

#include <recon/errors.h>
#include <recon/geometry.h>

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

/// The convex hull of points that all lie on it: corners of a box, two circles of a cylinder, a cone's circle and tip.
/// Few and even as these are, polar balls say little of them, or are all the same; the hull is what they bound. Points
/// within a millionth of the diagonal below it count. \returns it with all points on it for vertices, flat
/// faces' included, but those a little below. None if a point lies inside, if they do not span a volume, or are more
/// than 2,000 and so sampled densely enough to tell by themselves. \pre finite.
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

/// What to tell the user then.
constexpr const char* convex_text = "All points lie on their convex hull: the surface is that hull.";

} // namespace recon
