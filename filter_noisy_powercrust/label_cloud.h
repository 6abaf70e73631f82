#pragma once

#include "prepare_samples.h"

#include <recon/crust_mesh.h>
#include <recon/labelled_balls.h>
#include <recon/progress.h>

#include <optional>

namespace recon
{

/// A prepared cloud and its polar balls, inner told from outer.
struct LabelledCloud
{
    PreparedSamples cloud;
    LabelledBalls labelled;
    int completed = 0;       ///< Samples put on bare flat faces, the last of the cloud's [count].
    bool opened = false;     ///< Whether lids were taken off hollows whose walls object to being filled.
    int backs = 0;           ///< Samples put behind sheets that had the outside on both sides [count].
    double lost_sheets = 0;  ///< Share of samples in such sheets of a crust with handles, before they had backs [0..1].
    bool lost_walls = false; ///< Whether bare lids seem to close what walls hold that were taken for noise.
    /// Polygons of the crust, listed once: labels may be judged by their crust before it is made.
    std::optional<CrustPolygons> polygons = {};
    CrustPolygons& list_polygons(int threads);
};

/// Prepares the samples and labels their polar balls; where faces are bare, again with these completed, and the labels
/// that contradict less stay. A result that the points contradict has rivals: of a denoised cloud whose crust has lost
/// walls that read as noise, the same with half the noise and less, and, if it has no completed faces, with its lids
/// open; of a clean cloud whose votes are violated, balls kept by the spacing alone, and the denoised cloud where the
/// crust misses points (an open scan that outer balls flood, coarse limbs); of lace, the denoised cloud with backs
/// behind the sheets. \param labelling with lengths in input units.
LabelledCloud label_cloud(const Points& points, const SamplePreparationOptions& options,
                          const BallLabellingOptions& labelling, PhaseTimes& times, const Progress& progress = {});

} // namespace recon
