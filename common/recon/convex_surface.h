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

    /// Whether a closed mesh holds more than the hull, so that it goes astray between the points.
    bool is_exceeded_by(const TriangleMesh& other) const;
};

/// The convex hull of points that all lie on it: corners of a box, two circles of a cylinder, a cone's circle and tip.
/// Few and even as these are, polar balls say little of them, or are all the same; the hull is what they bound. Points
/// within a millionth of the diagonal below it count. \returns it with all points on it for vertices, flat
/// faces' included, but those a little below. None if a point lies inside, if they do not span a volume, or are more
/// than 2,000 and so sampled densely enough to tell by themselves. \pre finite.
std::optional<ConvexSurface> find_convex_surface(const Points& points);

/// The hull where nothing else goes through all points, where `reconstruct` fails or holds more, or where it took so
/// few points for noisy that they do not tell noise from a shape; else what that found. \param hull none: there is no
/// choice. \param is_denoised of a result. \param take makes a result of the hull.
template <class Reconstruct, class IsDenoised, class Take>
auto hull_or(std::optional<ConvexSurface> hull, const Reconstruct& reconstruct, const IsDenoised& is_denoised,
             const Take& take) -> decltype(reconstruct())
{
    constexpr std::size_t too_few_for_noise = 100;
    if (!hull)
        return reconstruct();
    if (hull->has_points_within_faces)
        try
        {
            auto found = reconstruct();
            const bool is_doubtful = hull->points.size() < too_few_for_noise && is_denoised(found);
            if (!is_doubtful && !hull->is_exceeded_by(found.mesh))
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
