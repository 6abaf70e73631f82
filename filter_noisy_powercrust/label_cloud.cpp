#include "label_cloud.h"

#include "complete_noisy_flats.h"

#include <recon/crust_mesh.h>
#include <recon/mismatch.h>
#include <recon/parallel.h>

#include <optional>
#include <utility>

namespace recon
{
namespace
{

/// Below this share of violated votes clean clouds missed no points; the question would take a tenth of the time.
constexpr double suspicious_votes = 0.01;
/// Share of points that a right surface may miss, at ears and folds.
constexpr double bearable_miss = 0.01;
/// Share of the area without points above which a hollow may have been closed over.
constexpr double bearable_bare = 0.05;
/// A rival that keeps more balls fits any points better; it must have less than this share of the mismatch.
constexpr double clearly_better = 0.5;
/// Above this number of points two attempts are not kept side by side [count].
constexpr std::size_t most_points_twice = 1'000'000;

/// Up to this share of violated votes a denoised cloud is not searched for bare faces.
constexpr double calm_votes = 0.005;
/// Up to this share of violated votes completed flat faces are not doubted.
constexpr double certain_votes = 0.02;

/// Attempts at one cloud.
class Attempts
{
public:
    Attempts(const Points& points, const SamplePreparationOptions& options, const BallLabellingOptions& labelling,
             PhaseTimes& times)
        : points_(points), options_(options), labelling_(labelling), times_(times)
    {
    }

    LabelledCloud prepare_and_label(Denoise denoise, const Progress& progress)
    {
        SamplePreparationOptions options = options_;
        options.denoise = denoise;
        PreparedSamples cloud = prepare_samples(points_, options, times_, progress.part(0, 0.35, "preparation"));
        return label(std::move(cloud), false, progress.part(0.35, 1, "labels"));
    }

    /// The points of an earlier attempt as they are, all balls kept by the spacing alone.
    LabelledCloud label_fine(PreparedSamples cloud, const Progress& progress)
    {
        if (cloud.outliers > 0)
            cloud.choose_frame(points_, points_);
        cloud.samples = cloud.distinct;
        cloud.normals.clear();
        cloud.surface.reset();
        if (cloud.denoised)
            cloud.completion = {}; // on projected samples
        cloud.denoised = cloud.is_noisy = false;
        cloud.outliers = 0;
        return label(std::move(cloud), true, progress);
    }

    Mismatch measure(const LabelledCloud& found)
    {
        times_.begin("mismatch");
        const TriangleMesh crust = extract_crust(found.labelled.regular, found.labelled.labels, labelling_.threads);
        return measure_mismatch(found.cloud.distinct, crust, labelling_.threads);
    }

private:
    LabelledCloud label(PreparedSamples cloud, bool fine, const Progress& progress)
    {
        BallLabellingOptions in_units = labelling_;
        in_units.ball_threshold /= cloud.frame.scale();
        in_units.noise /= cloud.frame.scale();
        in_units.fine = fine;
        const auto label_samples = [&](double from, double to) {
            return label_polar_balls(cloud.samples, cloud.normals, in_units, times_,
                                     progress.part(from, to, "polar balls"));
        };
        LabelledBalls plain = label_samples(0, 0.8);
        std::optional<Completion> completion = complete(cloud, plain.violated_votes);
        if (!completion)
            return {std::move(cloud), std::move(plain)};
        LabelledBalls completed = label_samples(0.8, 1);
        // A face that is none contradicts the samples around it; the benefit of the doubt is with the points as they
        // are.
        if (completed.violated_votes <= certain_votes || completed.violated_votes <= 0.5 * plain.violated_votes)
            return {std::move(cloud), std::move(completed), completion->added};
        cloud.samples = std::move(completion->samples_before);
        cloud.normals = std::move(completion->normals_before);
        return {std::move(cloud), std::move(plain)};
    }

    struct Completion
    {
        Points samples_before;
        Vectors normals_before;
        int added = 0; ///< The last of the cloud's samples [count].
    };

    /// Puts samples on bare flat faces; in noise they take the place of those around their rims.
    std::optional<Completion> complete(PreparedSamples& cloud, double violated)
    {
        Points added = cloud.completion.points;
        Vectors normals;
        std::vector<char> is_replaced(cloud.samples.size(), 0);
        if (cloud.denoised)
        {
            if (violated <= calm_votes || !(cloud.noise > 0))
                return {};
            times_.begin("flat faces");
            NoisyFlatCompletion flats =
                complete_noisy_flats(cloud.distinct, cloud.noise / cloud.frame.scale(), cloud.samples, cloud.normals,
                                     resolve_threads(options_.threads));
            added = std::move(flats.points);
            normals = std::move(flats.normals);
            is_replaced = std::move(flats.is_replaced);
        }
        if (added.empty())
            return {};
        Completion result{std::move(cloud.samples), std::move(cloud.normals), int(added.size())};
        cloud.samples.clear();
        cloud.normals.clear();
        for (std::size_t i = 0; i < result.samples_before.size(); ++i)
            if (!is_replaced[i])
            {
                cloud.samples.push_back(result.samples_before[i]);
                if (cloud.denoised)
                    cloud.normals.push_back(result.normals_before[i]);
            }
        cloud.samples.insert(cloud.samples.end(), added.begin(), added.end());
        cloud.normals.insert(cloud.normals.end(), normals.begin(), normals.end());
        return result;
    }

    const Points& points_;
    const SamplePreparationOptions& options_;
    const BallLabellingOptions& labelling_;
    PhaseTimes& times_;
};

} // namespace

LabelledCloud label_cloud(const Points& points, const SamplePreparationOptions& options,
                          const BallLabellingOptions& labelling, PhaseTimes& times, const Progress& progress)
{
    Attempts attempts(points, options, labelling, times);
    std::optional<LabelledCloud> first =
        attempts.prepare_and_label(options.denoise, progress.part(0, 0.7, "first attempt"));
    // A threshold of the user's that leaves no inner ball is no failure: normals would only dress it up.
    if (options.denoise != Denoise::automatic || labelling.ball_threshold > 0)
        return std::move(*first);
    const bool denoised = first->cloud.denoised;
    const double violated = first->labelled.violated_votes;
    if (denoised ? !first->cloud.is_doubtful : violated <= suspicious_votes)
        return std::move(*first);
    Mismatch mismatch = attempts.measure(*first);
    const auto misses_points = [&] { return mismatch.missed_points > bearable_miss; };
    const bool is_flooded = !denoised && violated > flooded_above;
    // Walls that a little noise made look noisy lose their balls; then all votes across them say that the cup is full.
    const bool loses_walls = mismatch.bare_area > bearable_bare || (denoised && misses_points());
    if (loses_walls && !is_flooded && points.size() <= most_points_twice)
    {
        LabelledCloud fine = attempts.label_fine(first->cloud, progress.part(0.7, 0.8, "fine balls"));
        const Mismatch own = attempts.measure(fine);
        // Bare flats stay bare: there both are wrong, and the first less so. Votes of other samples do not compare, but
        // a sponge across the hole of an open scan leaves nothing bare.
        if (fine.labelled.violated_votes < (denoised ? flooded_above : violated) &&
            own.sum() < clearly_better * mismatch.sum())
        {
            first = std::move(fine);
            mismatch = own;
        }
    }
    if (denoised || (!misses_points() && !is_flooded))
        return std::move(*first);
    if (points.size() > most_points_twice)
        first.reset();
    {
        LabelledCloud second = attempts.prepare_and_label(Denoise::on, progress.part(0.8, 0.9, "second attempt"));
        if (is_flooded ? second.labelled.violated_votes < violated : attempts.measure(second).sum() < mismatch.sum())
            return second;
    }
    return first ? std::move(*first)
                 : attempts.prepare_and_label(options.denoise, progress.part(0.9, 1, "first attempt again"));
}

} // namespace recon
