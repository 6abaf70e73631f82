#pragma once

#include "label_samples.h"
#include "prepare_samples.h"

#include <recon/labelling/labelled_balls.h>
#include <recon/mesh/mismatch.h>
#include <recon/progress.h>

#include <cstddef>

namespace recon
{

/// Above this number of points two attempts are not kept side by side [count].
inline constexpr std::size_t most_points_twice = 1'000'000;

/// An attempt, and how far its crust and the points do not match.
struct Judged
{
    LabelledCloud attempt;
    Mismatch mismatch;
    int handles = 0;                 ///< Genus of the crust.
    std::optional<double> lack = {}; ///< See measure_lack(), if it was asked for.

    bool has_lids() const { return mismatch.bare_area > bare_lid; }
};

/// Attempts at one cloud: what each needs, and what it leaves for the next.
class Attempts
{
public:
    /// Keeps references. \param labelling with lengths in input units.
    Attempts(const Points& points, const SamplePreparationOptions& options, const BallLabellingOptions& labelling,
             PhaseTimes& times)
        : points(points), options(options), times(times), labelling_(labelling)
    {
    }

    /// \param noise standard deviation [length], 0 = estimate.
    PreparedSamples prepare(Denoise denoise, double noise, const Progress& progress);
    LabelledCloud prepare_and_label(Denoise denoise, double noise, const Progress& progress);
    /// The points as they are, all balls kept by the spacing alone. \param most_violated see BallLabellingOptions.
    LabelledCloud label_fine(double most_violated, const Progress& progress);
    /// The same of the points of an earlier attempt.
    LabelledCloud label_fine(PreparedSamples cloud, double most_violated, const Progress& progress);
    LabelledCloud label(PreparedSamples cloud, BallLimit limit, const Progress& progress, double most_violated = 1);

    TriangleMesh extract(LabelledCloud& found);
    Judged judge(LabelledCloud attempt);

    /// The AMLS surface of a clean cloud's points, in its order.
    const AmlsSurface& find_clean_surface(const PreparedSamples& cloud, const Progress& progress);
    Vectors list_clean_normals(const PreparedSamples& cloud, const Progress& progress);

    /// With lengths in units of the cloud's frame.
    BallLabellingOptions options_for(const PreparedSamples& cloud) const;
    BallLabellingOptions usual_options_for(const PreparedSamples& cloud) const;

    /// What attempts leave for the next: after one that was in vain, what was known before it.
    struct Known
    {
        double noise = 0;
        bool is_sharing_disputed =
            false; ///< Of samples of an earlier denoised attempt: those of the next would be, too.
    };
    const Known& known() const { return known_; }
    void restore(const Known& before) { known_ = before; }

    /// The most noise that was estimated or given so far [length]; attempts that assume less do not have less.
    double noise() const { return known_.noise; }
    int threads() const { return labelling_.threads; }

    const Points& points;
    const SamplePreparationOptions& options;
    PhaseTimes& times;

private:
    BallLimit limit_for(const PreparedSamples& cloud) const;

    const BallLabellingOptions& labelling_;
    LatestSurface latest_;
    Known known_;
};

} // namespace recon
