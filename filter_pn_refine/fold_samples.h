#pragma once

#include "added_samples.h"
#include "initial_fans.h"
#include "usable_samples.h"

namespace recon::pn
{

/// Samples for folds that the input shows too sparsely for PN triangles: rims of ears, tips of fingers, where the
/// normals of the nearest samples differ by more than neighbours' may. From each sample whose fan is open there, a walk
/// on the surface that interpolates the samples around (HermiteSurface) leads into the gap; where it comes among
/// samples again, what it passed is put in. `spacing` as from find_spacing().
AddedSamples sample_folds(const UsableSamples& usable, const InitialFans& fans, const std::vector<float>& spacing,
                          int threads, const Progress& progress);

} // namespace recon::pn
