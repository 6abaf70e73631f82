#pragma once

#include "usable_samples.h"

namespace recon::pn
{

/// How far normals are off [radians], standard deviation per tangent axis: from the median difference of a normal to
/// what a linear fit to those around predicts. At most 5,000 samples, evenly spread, are asked. \pre `nearest` is
/// there.
double estimate_normal_noise(const UsableSamples& usable);

/// How loosely a HermiteSurface should meet such normals. Sparse samples of a bent surface look a little as if their
/// normals were noisy, hence up to 10 degrees it meets them exactly.
double slack_of_gradients(double normal_noise);

/// How far normals and places contradict each other: median over samples of the root mean square of (n + m) . d / |d|
/// for neighbours d away with normal m, twice the sine by which both lean the same way against the chord. On a smooth
/// surface they lean against each other. Of 121 clouds of 3,500 exact samples no smooth one had more than 0.2; normals
/// interpolated over large triangles of parts have 0.3 to 0.9, and triangles built on them err more than flat ones.
/// Noise of the points counts as well. At most 5,000 samples, evenly spread, are asked.
double contradiction_of_normals(const UsableSamples& usable);
constexpr double much_contradiction = 0.28; ///< From here on it is worth a warning.

} // namespace recon::pn
