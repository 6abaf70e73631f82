#pragma once

#include "filter_amls/surface/surface.h"

#include <recon/geometry.h>
#include <recon/progress.h>

namespace recon
{

/// Normals of points, and the surface that was made of them on the way.
struct OutwardNormals
{
    Vectors normals; ///< Of unit length, one per point; consistent only where surface.open.
    AmlsSurfaceReport surface;
    bool is_exact = false;            ///< Whether the points are exact, so that the crust went through them.
    bool lies_between_sheets = false; ///< Whether the surface was made with more noise, see weaving.h.
    int of_crust = 0;                 ///< Points whose normal is the crust's [count].
};

/// Outward unit normals of points without any: those of the AMLS surface (project_to_amls()), but where the crust of a
/// closed cloud, see label_points(), knows better its own (normals_near_crust.h). Its votes know walls of little more
/// than a spacing from either side, where the surface's cells mix both, and edges that the surface rounds; where both
/// agree the surface's are smoother. What cameras or scanners saw faces them, open or closed around them, and
/// surface.seen_from are their places. Few points that all lie on their convex hull face out of it. \throws as
/// build_amls_surface().
OutwardNormals find_outward_normals(const Points& points, const AmlsOptions& options = {},
                                    const Progress& progress = {});

} // namespace recon
