#pragma once

#include "surface.h"

#include <recon/geometry.h>
#include <recon/progress.h>

namespace recon
{

/// Normals of points, and the surface that was made of them on the way.
struct OutwardNormals
{
    Vectors normals; ///< Of unit length, one per point; consistent only where surface.open.
    AmlsSurfaceReport surface;
    bool is_exact = false; ///< Whether the points are exact, so that a crust through them had a say.
};

/// Outward unit normals of points without any. Those of the AMLS surface (project_to_amls()) where the points are
/// noisy. Exact points have a crust through them, see label_only_exact_points(), whose votes know walls of little more
/// than a spacing from either side, where the surface's cells mix both: the normals are those of its vertices, or,
/// where both agree, the surface's, which are smoother. What a camera or scanner at the origin saw faces it, open or
/// closed around it, and surface.seen_from is its place. \throws as build_amls_surface().
OutwardNormals find_outward_normals(const Points& points, const AmlsOptions& options = {},
                                    const Progress& progress = {});

} // namespace recon
