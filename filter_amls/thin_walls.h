#pragma once

#include <recon/geometry.h>
#include <recon/labelled_balls.h>
#include <recon/progress.h>

#include <optional>

namespace recon
{

/// Whether exact samples lie on thin walls, and their labels have handles and contradict votes.
/// \param stacked see Cleanness::stacked. \param threads >= 1.
bool has_doubtful_handles(const LabelledBalls& found, double stacked, int threads);

/// Labels the balls of exact samples again, with the normals of their AMLS surface: across a thin wall or a narrow gap
/// the votes of the next sheet are as loud as those of the own. The labels, if they violate half as many votes and have
/// fewer handles than the ones `found` without normals, or fewer votes and half as many handles. \param samples,
/// normals, options, times as for label_polar_balls(). \throws Cancelled.
std::optional<LabelledBalls> label_thin_walls(const Points& samples, const Vectors& normals,
                                              const BallLabellingOptions& options, const LabelledBalls& found,
                                              PhaseTimes& times, const Progress& progress = {});

} // namespace recon
