#pragma once

#include <recon/geometry.h>

#include <optional>
#include <vector>

namespace recon
{

/// Coefficients of the quadric, and with them the fewest points that determine it.
constexpr int patch_coefficients = 6;
/// A neighbourhood this many residual heights wide is a piece of surface rather than the inside of the noise.
constexpr double patch_flatness = 4;

/// What a quadric's coefficients weigh at a place whose component 0 is along the normal.
using PatchRow = Eigen::Matrix<double, patch_coefficients, 1>;
inline PatchRow patch_row(const Vector& u)
{
    PatchRow row;
    row << 1, u[1], u[2], u[1] * u[1], u[1] * u[2], u[2] * u[2];
    return row;
}

/// Height of a neighbour over the best quadric, and its place in the principal frame [radii].
struct PatchResidual
{
    Vector place; ///< Component 0 along the normal.
    double height;
};

/// A quadric height field over neighbours of a point.
struct PatchFit
{
    double height;   ///< Root mean square height over the quadric [length].
    double distance; ///< Root mean square distance from it: to first order the height over sqrt(1 + slope^2) [length].
    double kurtosis; ///< Of the heights: 3 for Gaussian noise, below 2 for two sheets taken for one.
    Vector normal;   ///< Of the principal frame.
    Point foot;      ///< Of the first neighbour, along the normal of the principal frame.
};

/// Best quadric over the first `count` neighbours, in their principal frame; `seed` is where its foot is wanted.
/// \param radius of the neighbourhood [length]. \param residuals replaced; empty if there are too few neighbours.
PatchFit fit_patch(const Points& points, const Point& seed, const int* neighbours, int count, double radius,
                   std::vector<PatchResidual>& residuals);

/// Two parallel sheets taken for one layer.
struct TwoSheets
{
    double sigma;    ///< Noise of each: standard deviation of the distances to it [length].
    double kurtosis; ///< Of these distances: 3 of Gaussian noise, less of an evenly filled layer's halves.
    double between;  ///< Share of the neighbours in the middle fifth of what lies between the sheets.
};

/// The two parallel sheets a few times the noise apart on which the neighbours lie, as those of a thin plate; nothing
/// if they do not. Of an evenly filled layer half the places read as two. With a step between the sheets the quadric
/// leaves less than half of what it leaves without (0.6 for Gaussian noise), and neighbours along the surface are as
/// often on different sheets as on the same; what a quadric cannot follow changes sign slowly. Sheets nearer than 1.3
/// spacings may be scans out of register, which are one. \param radius of the neighbourhood [length].
std::optional<TwoSheets> fit_two_sheets(const std::vector<PatchResidual>& residuals, double radius);

} // namespace recon
