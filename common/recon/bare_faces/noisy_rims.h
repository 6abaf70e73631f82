#pragma once

#include <recon/bare_faces/planar_faces.h>
#include <recon/bare_faces/slab_spots.h>

#include <Eigen/Core>

#include <vector>

namespace recon
{

/// Shares of points on no rim: the rims that explain most come first.
inline constexpr double rim_strays[] = {0.05, 0.1, 0.2};
/// Fewest samples of a face.
inline constexpr int fewest_rim_samples = 12;

/// Denoised samples of rims, and the bare faces that they enclose.
struct FilledRims
{
    std::vector<Eigen::Vector2d> rims; ///< Places in the plane.
    PlanarFaces found;                 ///< Those that are wide and hold no sample; indices of `rims`.
};

/// Draws the points of a slab together into curves, merges those of a spot into one sample and fills what these rims
/// enclose. \param points none of them where the surface crosses the plane. \param noise standard deviation > 0.
/// \returns nothing if more of them lie on no rim than the largest share of strays.
FilledRims fill_noisy_rims(const SlabPoints& points, double noise);

} // namespace recon
