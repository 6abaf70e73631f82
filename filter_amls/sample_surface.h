#pragma once

#include "surface.h"

#include <recon/geometry.h>
#include <recon/progress.h>

namespace recon
{

/// Clean, even, oriented samples of an AMLS surface. Lengths are in input units.
struct SurfaceSamples
{
    OrientedSamples samples; ///< In spatial order.
    int outliers = 0;        ///< Points that the surface does not claim [count].
};

/// Projects the points the surface was made of onto it, leaves outliers out, and thins what is left to Poisson disks of
/// 0.4 widths: what a crust is made of after denoising. \throws Cancelled.
SurfaceSamples sample_amls_surface(const Points& points, const AmlsSurface& surface, int threads,
                                   const Progress& progress = {});

} // namespace recon
