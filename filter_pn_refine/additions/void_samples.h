#pragma once

#include "filter_pn_refine/creases/mouths.h"
#include "filter_pn_refine/samples/added_samples.h"
#include "filter_pn_refine/samples/usable_samples.h"
#include "filter_pn_refine/step/initial_fans.h"

#include <recon/progress.h>

#include <vector>

namespace recon::pn
{

/// Samples put into voids, as random samples leave them: the centres of triangles of the fans whose circles are wide
/// against the usual distance between samples. A step puts as much into a void as between samples that lie as usual, so
/// that in spacings it would stay as wide for a step or two. None at rims, in folds, beside creases where normals
/// say that the surface may do anything between the corners, and where one of these is frozen. \param spacing per
/// sample, the usual distance around it. \param slack as of move_onto_sample_surface(). \param mouths may be null.
AddedSamples sample_voids(const UsableSamples& usable, const InitialFans& fans, const std::vector<float>& spacing,
                          double slack, const Mouths* mouths, int threads, const Progress& progress);

} // namespace recon::pn
