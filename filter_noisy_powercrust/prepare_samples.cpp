#include "prepare_samples.h"

#include "filter_amls/sample_surface.h"

#include <recon/cleanness.h>
#include <recon/crust_mesh.h>
#include <recon/mismatch.h>
#include <recon/noise.h>
#include <recon/parallel.h>
#include <recon/spatial_order.h>

#include <algorithm>
#include <optional>
#include <utility>

namespace recon
{
namespace
{

/// Below this share of violated votes clean clouds missed no points; the question would take a tenth of the time.
constexpr double suspicious_votes = 0.01;
/// Above this share the outside floods the surface, which then has handles by the hundred and misses nothing.
constexpr double flooded_votes = 0.15;
/// Share of points that a right surface may miss, at ears and folds.
constexpr double bearable_miss = 0.01;
/// Share of the area without points above which a hollow may have been closed over.
constexpr double bearable_bare = 0.05;
/// Above this number of points two attempts are not kept side by side [count].
constexpr std::size_t most_points_twice = 1'000'000;

/// Up to this share of violated votes a denoised cloud is not searched for bare faces.
constexpr double calm_votes = 0.005;
/// Up to this share of violated votes completed flat faces are not doubted.
constexpr double certain_votes = 0.02;

FlatCompletion complete_flats_of(const Points& samples, const Vectors& normals, double noise, int threads, PhaseTimes& times)
{
    times.begin("flat faces");
    FlatFaceOptions options;
    options.noise = noise;
    options.threads = resolve_threads(threads);
    return complete_flats(samples, normals, options);
}

} // namespace

PreparedSamples prepare_samples(const Points& points, const SamplePreparationOptions& options, PhaseTimes& times,
                                const Progress& progress)
{
    times.begin("gate");
    check_spans_volume(points);
    PreparedSamples result(points);
    result.order = order_spatially(points).order;
    // Sorted, so that neither the order of the input nor equal points have a say in what follows.
    Points sorted;
    for (const int i : result.order)
    {
        sorted.push_back(points[i]);
        result.distinct.push_back(result.frame.to_unit(points[i]));
    }
    const Cleanness cleanness = measure_cleanness(result.distinct, resolve_threads(options.threads));
    result.cleanness = std::max(cleanness.long_cells, cleanness.flat_neighbours);
    // Noise leaves no plane to a hundredth of the spacing, so faces found there speak for clean points, however coarse.
    if (options.denoise == Denoise::automatic && options.noise == 0)
        result.completion = complete_flats_of(result.distinct, {}, 0, options.threads, times);
    const bool is_exact = !result.completion.points.empty();
    times.begin("gate");
    result.is_noisy = !cleanness.is_clean() && !is_exact;
    if (!result.is_noisy && !is_exact && options.denoise != Denoise::on)
    {
        NoiseOptions noise_options;
        noise_options.threads = options.threads;
        const NoiseEstimate found = estimate_noise(sorted, noise_options, progress.part(0, 0.1, "noise"));
        result.noise = options.noise > 0 ? options.noise : found.median_sigma();
        result.is_noisy = result.noise > options.bearable_noise * found.median_spacing();
    }
    result.denoised = options.denoise == Denoise::on || (options.denoise == Denoise::automatic && result.is_noisy);

    if (result.denoised || (options.needs_surface && result.is_noisy))
    {
        times.begin("AMLS");
        AmlsOptions amls;
        amls.noise = options.noise;
        amls.threads = options.threads;
        result.surface = build_amls_surface(sorted, amls, progress.part(0.1, 0.7, "AMLS surface"));
        result.noise = result.surface->report().noise;
    }
    if (result.denoised)
    {
        times.begin("projection");
        SurfaceSamples sampled =
            sample_amls_surface(sorted, *result.surface, options.threads, progress.part(0.7, 1, "AMLS projection"));
        result.outliers = sampled.outliers;
        result.samples = result.frame.to_unit(sampled.samples.points);
        result.normals = std::move(sampled.samples.normals);
    }
    // Too few left to span anything: then all were surface.
    if (result.samples.size() < 4)
    {
        result.denoised = false;
        result.samples = result.distinct;
        result.normals.clear();
    }
    times.end();
    return result;
}

LabelledCloud label_cloud(const Points& points, const SamplePreparationOptions& options, BallLabellingOptions labelling,
                          PhaseTimes& times, const Progress& progress)
{
    const auto measure = [&](const LabelledCloud& found)
    {
        times.begin("mismatch");
        const TriangleMesh crust = extract_crust(found.labelled.regular, found.labelled.labels, labelling.threads);
        return measure_mismatch(found.cloud.distinct, crust, labelling.threads);
    };
    const auto attempt = [&](Denoise denoise, bool fine, double begin, double end)
    {
        SamplePreparationOptions preparation = options;
        preparation.denoise = denoise;
        const double middle = begin + 0.35 * (end - begin);
        PreparedSamples cloud =
            prepare_samples(points, preparation, times, progress.part(begin, middle, "preparation"));
        BallLabellingOptions in_units = labelling;
        in_units.ball_threshold /= cloud.frame.scale();
        in_units.noise /= cloud.frame.scale();
        in_units.fine = fine;
        const auto label = [&](double from, double to)
        { return label_polar_balls(cloud.samples, cloud.normals, in_units, times, progress.part(from, to, "polar balls")); };
        const double late = middle + 0.8 * (end - middle);
        LabelledBalls plain = label(middle, late);
        if (cloud.denoised && plain.violated_votes > calm_votes)
            cloud.completion =
                complete_flats_of(cloud.samples, cloud.normals, cloud.noise / cloud.frame.scale(), options.threads, times);
        if (cloud.completion.points.empty())
            return LabelledCloud{std::move(cloud), std::move(plain)};
        const std::size_t measured = cloud.samples.size();
        cloud.samples.insert(cloud.samples.end(), cloud.completion.points.begin(), cloud.completion.points.end());
        cloud.normals.insert(cloud.normals.end(), cloud.completion.normals.begin(), cloud.completion.normals.end());
        LabelledBalls completed = label(late, end);
        // A face that is none contradicts the samples around it; the benefit of the doubt is with the points as they are.
        if (completed.violated_votes <= certain_votes || completed.violated_votes <= 0.5 * plain.violated_votes)
        {
            const int count = int(cloud.samples.size() - measured);
            return LabelledCloud{std::move(cloud), std::move(completed), count};
        }
        cloud.samples.resize(measured);
        if (!cloud.normals.empty())
            cloud.normals.resize(measured);
        return LabelledCloud{std::move(cloud), std::move(plain)};
    };
    std::optional<LabelledCloud> first = attempt(options.denoise, false, 0, 0.7);
    // A threshold of the user's that leaves no inner ball is no failure: normals would only dress it up.
    if (options.denoise != Denoise::automatic || first->cloud.denoised || labelling.ball_threshold > 0 ||
        first->labelled.violated_votes <= suspicious_votes)
        return std::move(*first);
    Mismatch mismatch = measure(*first);
    const bool is_flooded = first->labelled.violated_votes > flooded_votes;
    // Walls that a little noise made look noisy lose their balls; then all votes across them say that the cup is full.
    if (!is_flooded && mismatch.bare_area > bearable_bare && points.size() <= most_points_twice)
    {
        LabelledCloud fine = attempt(options.denoise, true, 0.7, 0.8);
        const Mismatch own = measure(fine);
        // Bare flats stay bare: there both are wrong, and the first less so.
        if (fine.labelled.violated_votes < first->labelled.violated_votes && own.sum() < 0.5 * mismatch.sum())
        {
            first = std::move(fine);
            mismatch = own;
        }
    }
    if (mismatch.missed_points <= bearable_miss && !is_flooded)
        return std::move(*first);
    const double violated = first->labelled.violated_votes;
    if (points.size() > most_points_twice)
        first.reset();
    {
        LabelledCloud second = attempt(Denoise::on, false, 0.8, 0.9);
        if (is_flooded ? second.labelled.violated_votes < violated : measure(second).sum() < mismatch.sum())
            return second;
    }
    return first ? std::move(*first) : attempt(options.denoise, false, 0.9, 1);
}

} // namespace recon
