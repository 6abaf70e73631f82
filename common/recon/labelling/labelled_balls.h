#pragma once

#include <recon/labelling/ball_scale.h>
#include <recon/labelling/signed_graph.h>
#include <recon/progress.h>
#include <recon/triangulation/polar_balls.h>
#include <recon/triangulation/power_diagram.h>
#include <recon/triangulation/triangulation.h>

#include <algorithm>
#include <array>
#include <functional>
#include <utility>
#include <vector>

namespace recon
{

/// Where a polar ball of samples without normals is too small to stay, if no threshold is given.
enum class BallLimit
{
    local,       ///< By the local scale, see choose_scale(): around samples that look noisy larger ones go, too.
    fine,        ///< Nothing is noise: by the spacing alone, however thin the part that they fill.
    fewest_votes ///< Whichever of these two contradicts fewer votes: for clouds that are clean, but perhaps for parts.
};

/// Whether samples share polar balls, see share_poles(): fewer balls take less time.
enum class BallSharing
{
    none,
    undisputed, ///< As long as the labels contradict next to none of the samples' votes.
    always
};

/// Options of label_polar_balls(). Lengths are in the unit frame.
struct BallLabellingOptions
{
    double ball_threshold = 0; ///< Smallest polar ball kept [unit length], >= 0. 0 = by the local scale.
    double noise = 0;          ///< Standard deviation of the noise, if known [unit length], >= 0.
    double noise_taken =
        0; ///< Standard deviation of the noise that samples with normals had [unit length], >= 0. 0 = not known.
    double deep_intersection = 0; ///< Cosine above which neighbours agree, 0..1. 0 = weigh in samples.
    BallLimit limit = BallLimit::local;
    BallSharing sharing = BallSharing::none;
    /// Share of violated votes above which the labels are of no use: they are not repaired, nor is another attempt made
    /// where a first one is far above it [0..1].
    double most_violated = 1;
    /// Balls that are outer, as numbered by an earlier run on the same samples with all else equal, in which none were
    /// shared. Normals then decide only where poles are sought, and none are shared.
    std::vector<int> opened;
    int threads = 1;

    /// These, with labels of no use above `violated` either.
    BallLabellingOptions within(double violated) const
    {
        BallLabellingOptions result = *this;
        result.most_violated = std::min(most_violated, violated);
        return result;
    }
};

/// Above this share of violated votes the outside floods the surface, which then misses nothing and has handles by the
/// hundred. Right results had up to 0.07, floods 0.2 to 0.9.
constexpr double flooded_above = 0.15;

/// Polar balls of a cloud, told inner from outer: what the crust and the medial axis are made of.
struct LabelledBalls
{
    PolarBalls kept;
    PowerDiagram diagram;  ///< Of the kept balls less the doubtful ones that were dropped.
    Triangulation regular; ///< diagram.triangulation()
    std::vector<Side> labels;
    std::vector<double> scale; ///< Per ball: local scale of the samples it touches [unit length].
    double spacing = 0;        ///< Median scale of the samples' spacing [unit length].
    double violated_votes = 0; ///< Share of the votes' weight that the labels contradict [0..1].
    /// Hidden balls, and for each the visible one that is nearly the same: of a sphere's thousands one is visible.
    std::vector<std::array<int, 2>> twins;
    bool is_shared = false; ///< Whether samples share balls.
};

/// Labels of samples with normals, or without if there are none, which are of no use above `most_violated`.
using LabelWithin = std::function<LabelledBalls(const Points& samples, const Vectors& normals, double most_violated)>;

/// Algorithm 4.1 of Mederos et al. (2005), steps 1 to 5, with a local threshold and a global labelling: Delaunay
/// triangulation, polar balls above the local scale, power diagram, labels from the balls' attraction, the samples'
/// votes and, where given, the samples' outward normals; then doubtful balls dropped, islands absorbed, doubtful and
/// short handles removed. Where the labels contradict a large part of the votes, votes and normals weigh more and
/// labels are found again. \param samples distinct, spanning a volume, of unit scale, best in spatial order. \param
/// normals empty, or one per sample of a cloud that is already free of noise. \throws Cancelled.
LabelledBalls label_polar_balls(Points samples, const Vectors& normals, const BallLabellingOptions& options,
                                PhaseTimes& times, const Progress& progress = {});

/// The same, given up above what is asked. `times` must outlive it.
inline LabelWithin label_within(BallLabellingOptions options, PhaseTimes& times, const Progress& progress = {})
{
    return [options = std::move(options), &times, progress](const Points& samples, const Vectors& normals,
                                                            double most_violated)
    { return label_polar_balls(samples, normals, options.within(most_violated), times, progress); };
}

} // namespace recon
