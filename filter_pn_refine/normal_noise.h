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

} // namespace recon::pn
