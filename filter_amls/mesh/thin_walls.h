#pragma once

#include <recon/geometry.h>
#include <recon/labelling/labelled_balls.h>
#include <recon/progress.h>

#include <functional>
#include <optional>

namespace recon
{

/// Labels the balls of exact samples again, with the normals of their AMLS surface, if they lie on thin walls and the
/// labels `found` without normals contradict votes and have handles: across a thin wall or a narrow gap the votes of
/// the next sheet are as loud as those of the own. The labels, if they violate half as many votes and have fewer
/// handles, or fewer votes and half as many handles. \param stacked see Cleanness::stacked. \param list_normals makes
/// the normals, where they are needed. \param samples, options, times as for label_polar_balls(). \throws Cancelled.
std::optional<LabelledBalls> label_thin_walls(const Points& samples, double stacked,
                                              const std::function<Vectors(const Progress&)>& list_normals,
                                              const BallLabellingOptions& options, const LabelledBalls& found,
                                              PhaseTimes& times, const Progress& progress = {});

} // namespace recon
