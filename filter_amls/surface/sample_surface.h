#pragma once

#include "surface.h"

#include <recon/geometry.h>
#include <recon/progress.h>

#include <vector>

namespace recon
{

/// Clean, even, oriented samples of an AMLS surface. Lengths are in input units.
struct SurfaceSamples
{
    OrientedSamples samples;  ///< In spatial order.
    std::vector<int> claimed; ///< Distinct points that the surface claims, in spatial order.
    int outliers = 0;         ///< The other distinct points [count].
};

/// Projects the points the surface was made of onto it, leaves outliers out, and thins what is left to Poisson disks of
/// 0.4 widths: what a crust is made of after denoising. \throws Cancelled.
SurfaceSamples sample_amls_surface(const Points& points, const AmlsSurface& surface, int threads,
                                   const Progress& progress = {});

/// Outward unit normals of an AMLS surface at points, sided as those of its samples are. \throws Cancelled.
Vectors list_surface_normals(const Points& points, const AmlsSurface& surface, int threads,
                             const Progress& progress = {});

} // namespace recon
