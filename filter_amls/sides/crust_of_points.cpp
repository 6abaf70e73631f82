#include "crust_of_points.h"

#include <recon/errors.h>
#include <recon/noise/cleanness.h>

#include <utility>

namespace recon
{
namespace
{

/// Cleanness::least_roughness above which, and Cleanness::flat_neighbours below which the crust is in shreds: thin
/// walls have up to 0.33 and at least 0.5 with noise of 0.3 spacings; 0.34 to 0.4 with 0.7, and 0.37 to 0.5 in clouds
/// of noisy copies.
constexpr double much_noise = 0.34, few_flat = 0.5;
/// Share of violated votes above which the crust is not trusted; it is wrong from 0.055 on, mostly.
constexpr double bearable_votes = 0.06;

} // namespace

BallLabellingOptions options_for_labels(int threads)
{
    BallLabellingOptions options;
    options.sharing = BallSharing::undisputed; // the crust goes through the samples
    options.limit = BallLimit::fewest_votes;   // of exact points
    options.threads = threads;
    return options;
}

const CrustOfPoints::Made* CrustOfPoints::find(const Points& points, int threads, const Progress& progress)
{
    if (is_asked_)
        return made();
    const Cleanness cleanness = measure_cleanness(points, threads);
    if (cleanness.least_roughness <= much_noise && cleanness.flat_neighbours >= few_flat)
    {
        BallLabellingOptions options = options_for_labels(threads);
        options.most_violated = bearable_votes;
        PhaseTimes times;
        LabelledBalls labelled = label_polar_balls(points, {}, options, times, progress.part(0, 0.8));
        if (labelled.violated_votes <= bearable_votes)
            try
            {
                CrustNormals crust = list_crust_normals(points, labelled, threads, progress.part(0.8, 1));
                made_ = Made{std::move(labelled), std::move(crust)};
            }
            catch (const AlgorithmFailure&) // nothing is inside
            {
            }
    }
    is_asked_ = true;
    return made();
}

} // namespace recon
