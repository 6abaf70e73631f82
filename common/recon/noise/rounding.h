#pragma once

#include <recon/geometry.h>
#include <recon/scan/depth_image.h>

#include <optional>

namespace recon
{

/// To what the coordinates of a cloud were rounded, if its points lie as densely as what they were rounded to: then
/// many lie exactly in one plane, as samples without noise do, and only this tells how far they may be off.
struct Rounding
{
    /// Of voxels, the longest of the three; of a height field, of its heights [length]. 0 if not to a lattice.
    /// Of an axis that alone was rounded, more coarsely than the points are dense, as metres far north in single
    /// precision are, half a metre: its step.
    double lattice_step = 0;
    double lattice_error = 0; ///< Standard deviation of the noise that the points are taken to have, at least [length].
    Vector lattice_steps = Vector::Zero(); ///< Per axis [length].
    std::optional<DepthCamera> camera;     ///< Whose depths come in steps.

    explicit operator bool() const { return lattice_step > 0 || camera; }
    /// The same in another frame.
    Rounding in(const UnitFrame& frame) const;
    /// Points of a lattice anywhere in their cells: what they are off by is then like other noise.
    Points dither(const Points& points) const;
};

/// Standard deviation of a lattice's points from the surface [steps]: 0.29 where coordinates were rounded, 0.38 to 0.40
/// of all voxels that a surface passes through.
inline constexpr double error_of_lattice = 0.35;
/// What estimate_noise() says of a lattice's dithered points without other noise [lattice errors]: 1.54 to 1.71.
inline constexpr double estimate_of_dithered = 1.6;
/// Noise below which the lattice's error is all there is [lattice errors].
inline constexpr double most_error_of_lattice = 1.29;

/// Lattices along the axes. Shapes with most of their points on lattice planes, such as boxes, are exact, and so are
/// slices. \param points distinct, in spatial order, finite.
Rounding find_rounding(const Points& points);

} // namespace recon
