#pragma once

#include <recon/geometry.h>
#include <recon/search/block_search.h>

#include <optional>
#include <vector>

namespace recon
{

/// A depth camera whose pixels a cloud is.
struct DepthCamera
{
    Point place;                ///< All that it saw faces it.
    Vector ahead;               ///< Along which depths are measured, of unit length.
    double pixel = 0;           ///< Distance of neighbouring rays at a depth of 1 [length].
    std::vector<double> depths; ///< Those that occur, ascending [length], if hardly a tenth as many as points; or none.

    /// Distance of neighbouring depths around a point [length]; 0 if they take any value.
    double step_at(const Point& p) const;
    /// Whether most of the points around lie at its depth, so that they say nothing of the others. \param search of
    /// the points.
    bool is_in_step(const Point& p, const Points& points, const BlockSearch& search) const;
    /// The same in another frame.
    DepthCamera in(const UnitFrame& frame) const;
};

/// The camera if points are its pixels as it delivers them: from the origin, along an axis, they lie on a grid,
/// whatever their depths. Grids of a plane or a terrain do not count: they are even by themselves, or reach over depths
/// that differ by less than a quarter. A cloud that was moved, thinned or merged looks like any other, unless its order
/// tells (viewpoint.h). \pre finite.
std::optional<DepthCamera> find_depth_camera(const Points& points);

/// The same if its depths come in steps of half a pixel and more, in each of which many points lie side by side: steps
/// look like sheets, and the points of each like those of a plane without noise. \param points in spatial order.
std::optional<DepthCamera> find_coarse_depth_camera(const Points& points);

} // namespace recon
