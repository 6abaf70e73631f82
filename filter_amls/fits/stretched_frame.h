#pragma once

#include "weighted_sums.h"

#include <Eigen/Core>

namespace recon
{

constexpr double most_stretch = 1.8; ///< Of either axis: windows are at most 3.2 times as long as wide.

/// Frame for a fit over a window that is longer along a bend than across it, and holds as many points: a round window
/// is too wide across ridges, grooves, edges and limbs, or too narrow along them. The axes lie along the principal
/// directions of a fit made before and are s and 1/s long, s^2 = ((|k1| + k0) / (|k2| + k0))^1.5, k the eigenvalues of
/// its Q; k0 = sigma / width^2 is a bend that noise hides. Where few points count s stays near 1.
/// \param frame of `fit`. \param normal of the frame to be made, unit length. \param width of the fit [length].
/// \param sigma standard deviation of the noise [length].
TangentFrame stretch_along_bend(const QuadricFit& fit, const TangentFrame& frame, const Vector& normal, double width,
                                double sigma);

/// How much longer the longer axis is, >= 1.
double stretch_of(const TangentFrame& frame);

/// Q of a quadric with the height u^T Q u, u from the frame's origin [1/length].
Eigen::Matrix3d bending_of(const QuadricFit& fit, const TangentFrame& frame, double width);

/// The fit with its bending told in another frame with nearly the same normal; there it has neither offset nor slope.
QuadricFit with_bending_in(const TangentFrame& other, const QuadricFit& fit, const TangentFrame& frame);

} // namespace recon
