#pragma once

#include "refine.h"

#include <recon/geometry.h>
#include <recon/progress.h>

namespace recon::pn
{

/// Normals that were computed from the points around each are round at edges. Where planes of samples around pass
/// through a sample, these samples lie on its face, and their normals are averaged, again and again (bilateral
/// filtering: Tomasi and Manduchi 1998, of normals as Oeztireli et al. 2009), so that sharp edges turn up in exact
/// clouds. \returns these normals if they show creases (detect_creases()) at more than the crease angle of the options,
/// else those given: noise and smooth shapes gain nothing.
Vectors sharpen_normals(const OrientedSamples& samples, const PnRefineOptions& options, const Progress& progress = {});

} // namespace recon::pn
