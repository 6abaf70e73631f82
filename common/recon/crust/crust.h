#pragma once

#include <recon/labelling/labelled_balls.h>
#include <recon/mesh/crust_mesh.h>
#include <recon/mesh/kept_components.h>

#include <recon/geometry.h>
#include <recon/progress.h>

#include <functional>
#include <string>

namespace recon
{

/// Options of make_crust().
struct CrustOptions
{
    KeepComponents keep_components = KeepComponents::automatic;
    bool simplify = true;    ///< Collapse short edges.
    int target_vertices = 0; ///< Vertices to collapse down to, as far as no long edge must go [count].
    std::function<Viewpoints()> find_viewpoints; ///< Of the samples, in the unit frame; see drop_components().
    const Points* interpolated = nullptr; ///< With `simplify`: the labelled samples, if they are free of noise; the
                                          ///< crust passes through them then, and has about one vertex for each.
    int threads = 1;                      ///< [count], >= 1. The result does not depend on it.
};

/// Crust of labelled balls, in the unit frame: extracted, stray shells dropped, short edges collapsed. A closed
/// oriented manifold. \param dropped what was left out. \throws AlgorithmFailure if no
/// inner ball is left. \throws Cancelled.
TriangleMesh make_crust(const LabelledBalls& labelled, const CrustOptions& options, const Progress& progress = {},
                        DroppedBodies* dropped = nullptr);

/// The same. \param polygons list_crust_polygons() of the balls, for who has listed them already.
TriangleMesh make_crust(CrustPolygons polygons, const LabelledBalls& labelled, const CrustOptions& options,
                        const Progress& progress = {}, DroppedBodies* dropped = nullptr);

/// What a user should know of it, empty if that is nothing.
std::string describe(const DroppedBodies& dropped);
/// The same of the share of the samples' votes that a crust contradicts [0..1].
std::string describe_violation(double violated_votes);

} // namespace recon
