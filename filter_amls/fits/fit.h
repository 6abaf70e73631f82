#pragma once

#include "weighted_sums.h"

#include <recon/geometry.h>
#include <recon/progress.h>
#include <recon/search/block_search.h>

#include <array>
#include <vector>

namespace recon
{

/// A small piece of surface: the quadric d(x) = u.n - u^T Q u = 0, u = x - position.
struct Anchor
{
    Point position;
    Vector normal;                 ///< Unit length, outward.
    std::array<double, 6> bending; ///< Q: xx, yy, zz, xy, xz, yz.
    double confidence;             ///< Weight among other anchors, >= 0.
    double width;                  ///< h at the anchor [length].
};

constexpr double fit_cut = 2.4; ///< Samples farther than this from an anchor do not count [widths].
/// Nor do those whose normals have less than this cosine with that of the anchor.
constexpr double facing_cosine = 0.35;

/// What quadrics are fitted to: the points themselves, since the mean of a cell no longer tells good ones from bad.
struct FitSamples
{
    const Points& points; ///< In spatial order.
    const BlockSearch& search;
    std::vector<double> weights; ///< 0 for outliers.
    Vectors normals;             ///< Unit length, outward: points that face the other way do not count.
};

/// Place, plane and scales that the fit of an anchor begins with.
struct FitStart
{
    Point foot;
    Vector normal; ///< Unit length, outward.
    double width;  ///< h [length].
    double sigma;  ///< Standard deviation of the noise [length].
};

/// Robust scales below it let few points decide [sigma].
constexpr double picky_scale = 1.8;

/// Fits a quadric to the samples around each anchor, again and again, each time robustly about the one before
/// and over windows that follow its bends (README.md, step 7), and corrects it where the surface bends. Where that
/// fails, turns by more than 60 degrees or moves too far, the anchor stays the plane it began with.
/// \param robust_scale how far residuals may be off before they lose weight [sigma], see choose_robust_scale().
std::vector<Anchor> fit_anchors(const FitSamples& samples, const std::vector<FitStart>& starts, double robust_scale,
                                int threads, const Progress& progress = {});

/// Sets place, normal and bending from a fit over `width` in `frame` at `position`.
void place_anchor(Anchor& anchor, const Point& position, const TangentFrame& frame, const QuadricFit& fit,
                  double width);

} // namespace recon
