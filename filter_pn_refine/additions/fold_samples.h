#pragma once

#include "filter_pn_refine/samples/added_samples.h"
#include "filter_pn_refine/samples/usable_samples.h"
#include "filter_pn_refine/step/initial_fans.h"

#include <vector>

namespace recon::pn
{

/// Samples for folds that the input shows too sparsely for PN triangles: rims of ears, tips of fingers, where the
/// normals of the nearest samples differ by more than neighbours' may. From each sample whose fan is open there, unless
/// it is frozen, a walk on the surface that interpolates the samples around (HermiteSurface) leads into the gap; where
/// it comes among samples again, what it passed is put in. \param spacing as from find_spacing(). \param slack of the
/// surface's gradients. \param has_creases whether edges are sharp: then flat faces have no folds.
AddedSamples sample_folds(const UsableSamples& usable, const InitialFans& fans, const std::vector<float>& spacing,
                          double slack, bool has_creases, int threads, const Progress& progress);

} // namespace recon::pn
