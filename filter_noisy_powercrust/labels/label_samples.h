#pragma once

#include "prepare_samples.h"

#include <recon/labelling/labelled_balls.h>
#include <recon/mesh/crust_mesh.h>
#include <recon/progress.h>

#include <optional>

namespace recon
{

/// A prepared cloud and its polar balls, inner told from outer.
struct LabelledCloud
{
    PreparedSamples cloud;
    LabelledBalls labelled;
    int completed = 0;        ///< Samples put on bare flat faces, the last of the cloud's [count].
    bool opened = false;      ///< Whether lids were taken off hollows whose walls object to being filled.
    bool found_walls = false; ///< Whether walls were found with less noise assumed.
    int backs = 0;            ///< Samples put behind sheets that had the outside on both sides [count].
    double lost_sheets = 0;  ///< Share of samples in such sheets of a crust with handles, before they had backs [0..1].
    bool lost_walls = false; ///< Whether bare lids seem to close what walls hold that were taken for noise.
    bool is_between_sheets = false; ///< Whether more noise was assumed than was told, see weaving.h.
    bool has_filled_faces = false;  ///< Whether samples were put on bare faces, see bare_faces.h.
    bool is_settled = false;        ///< Whether no other labels are to be tried.
    /// Polygons of the crust, listed once: labels may be judged by their crust before it is made.
    std::optional<CrustPolygons> polygons = {};
    CrustPolygons& list_polygons(int threads);
};

/// Labels the polar balls of prepared samples; where flat faces are bare, again with these completed, and the labels
/// that contradict less stay. \param labelling with lengths in units of the cloud's frame. \throws Cancelled.
LabelledCloud label_samples(PreparedSamples cloud, const BallLabellingOptions& labelling, PhaseTimes& times,
                            const Progress& progress = {});

} // namespace recon
