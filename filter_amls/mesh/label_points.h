#pragma once

#include "filter_amls/surface/surface.h"

#include <recon/geometry.h>
#include <recon/labelling/labelled_balls.h>
#include <recon/progress.h>

#include <optional>
#include <vector>

namespace recon
{

/// What a crust is made of, in a unit frame.
struct LabelledSamples
{
    UnitFrame frame;
    Points samples;
    LabelledBalls labelled;
    int outliers = 0;              ///< Points left out [count].
    bool is_exact = false;         ///< Whether the samples are the points as they are.
    std::vector<int> claimed = {}; ///< Input points that the surface claims, if not exact.
    Vectors normals = {};          ///< Of the surface at the samples, if not exact and without backs.
    int backs = 0;                 ///< The last so many samples lie behind sheets that had the outside on both sides.
    double lost_sheets = 0;        ///< Share of samples in such sheets, if they got a back and are no ground [0..1].
    int completed = 0;             ///< The last so many samples were put on bare faces [count].
    double least_roughness = 0;    ///< Of exact points without a ground, see Cleanness::least_roughness [spacings].
    bool is_settled = false;       ///< Whether no other labels are to be tried.
};

/// Exact points as they are, unless their crust contradicts them, as where the deep hollow of a scan is filled, and
/// that of the surface's samples does less; else samples of the surface. \param surface of the points, here and below.
/// \throws AlgorithmFailure if all points are isolated. \throws Cancelled.
LabelledSamples label_points(const Points& points, const AmlsSurface& surface, bool may_be_exact,
                             const BallLabellingOptions& labelling, PhaseTimes& times, const Progress& progress);

/// The points as they are if they are thin tubes', see thin_tubes.h; none else. \throws Cancelled.
std::optional<LabelledSamples> label_only_tubes(const Points& points, const AmlsSurface& surface,
                                                const BallLabellingOptions& labelling, PhaseTimes& times,
                                                const Progress& progress);

/// Whether the points look open, and not for faces that carry none but on their rims: then some lie along lines.
bool is_open_sheet(const AmlsSurface& surface);

/// As label_points() if flat faces are completed: what looks open for these is closed; none else. \throws as it does.
std::optional<LabelledSamples> label_only_flats(const Points& points, const AmlsSurface& surface,
                                                const BallLabellingOptions& labelling, PhaseTimes& times,
                                                const Progress& progress);

} // namespace recon
