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
    bool is_exact = false; ///< Whether the points are exact, so that the crust went through them.
    int of_crust = 0;      ///< Points whose normal is the crust's [count].
};

/// Outward unit normals of points without any: those of the AMLS surface (project_to_amls()), but where the crust of a
/// closed cloud, see label_points(), differs from them those of its vertices. Its votes know walls of little more than
/// a spacing from either side, where the surface's cells mix both, and edges that the surface rounds; where both agree
/// the surface's are smoother. What a camera or scanner at the origin saw faces it, open or closed around it, and
/// surface.seen_from is its place. \throws as build_amls_surface().
OutwardNormals find_outward_normals(const Points& points, const AmlsOptions& options = {},
                                    const Progress& progress = {});

} // namespace recon
