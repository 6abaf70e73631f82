#include "prepare_samples.h"

#include "filter_amls/cells/isolated_points.h"
#include "filter_amls/surface/sample_surface.h"
#include "filter_amls/surface/surface_data.h"

#include <recon/errors.h>
#include <recon/noise/cleanness.h>
#include <recon/noise/rounding.h>
#include <recon/parallel.h>
#include <recon/search/spatial_order.h>

#include <algorithm>
#include <utility>

namespace recon
{
namespace
{

/// Noise that was given and is less needs no denoising [spacings].
constexpr double least_given_noise = 0.2;

bool span_volume(const Points& points)
{
    try
    {
        check_spans_volume(points);
        return true;
    }
    catch (const InvalidInput&)
    {
        return false;
    }
}

} // namespace

void PreparedSamples::choose_frame(const Points& spanning, const Points& points)
{
    frame = UnitFrame(spanning);
    distinct = frame.to_unit(points_at(order, points));
}

void PreparedSamples::leave_out(const std::vector<int>& ones, const Points& points)
{
    if (ones.empty())
        return;
    std::vector<int> rest = order_without(ones, order, points);
    if (!span_volume(points_at(rest, points)))
        return; // a cone's tip
    order = std::move(rest);
    outliers = isolated = int(ones.size());
    choose_frame(points_at(order, points), points);
}

const FlatCompletion& PreparedSamples::complete(PhaseTimes& times, int threads, const Progress& progress)
{
    if (!completion)
    {
        times.begin("flat faces");
        FlatFaceOptions exactly_flat;
        exactly_flat.threads = threads;
        completion = may_have_flats ? complete_flats(distinct, exactly_flat, progress) : FlatCompletion{};
    }
    return *completion;
}

const AmlsSurface& LatestSurface::find(const Points& points, const Points& sorted,
                                       const SamplePreparationOptions& options, const Progress& progress)
{
    if (!surface_ || noise_ != options.noise || !surface_->data().was_made_of(sorted))
    {
        AmlsOptions made;
        made.noise = options.noise;
        made.threads = options.threads;
        made.for_crust = true;
        made.as_scanned = &points;
        surface_ = build_amls_surface(sorted, made, progress, {}, surface_ ? &*surface_ : nullptr);
        noise_ = options.noise;
    }
    return *surface_;
}

PreparedSamples prepare_samples(const Points& points, const SamplePreparationOptions& options, LatestSurface& latest,
                                PhaseTimes& times, const Progress& progress)
{
    times.begin("gate");
    check_spans_volume(points);
    PreparedSamples result(points);
    const int threads = resolve_threads(options.threads);
    result.order = order_input(points, threads).order;
    // Sorted, so that neither the order of the input nor equal points have a say in what follows.
    Points sorted = points_at(result.order, points);
    result.distinct = result.frame.to_unit(sorted);
    Cleanness cleanness = measure_cleanness(result.distinct, threads);
    // In a noisy one it is denoising that drops outliers.
    if (options.denoise == Denoise::automatic && cleanness.is_clean())
    {
        times.begin("outliers");
        result.leave_out(find_isolated_points(result.distinct, threads, progress.part(0, 0.1, "outliers")), points);
        if (result.isolated > 0)
        {
            sorted = points_at(result.order, points);
            cleanness = measure_cleanness(result.distinct, threads);
        }
    }
    result.stacked = cleanness.stacked;
    result.cleanness = cleanness.share();
    times.begin("gate");
    // Rounded to steps many lie in a plane, but for an error that the steps tell.
    const bool is_rounded = options.denoise == Denoise::automatic && find_rounding(sorted);
    result.may_have_flats = options.denoise == Denoise::automatic && options.noise == 0 && !is_rounded;
    const bool is_told =
        cleanness.spacing > 0 && options.noise > least_given_noise * cleanness.spacing * result.frame.scale();
    result.is_noisy = is_told || is_rounded || cleanness.is_noisy_in_parts();
    if (!result.is_noisy)
    {
        const bool is_clean = cleanness.is_clean();
        const bool is_doubted = !is_clean || cleanness.is_smooth_but_noisy() || cleanness.is_doubtful() ||
                                (options.finds_any_noise && cleanness.is_hardly_noisy());
        // Noise leaves no plane to a hundredth of the spacing, so faces found there speak for clean points, however
        // coarse.
        result.is_noisy = is_doubted && result.complete(times, threads, progress.part(0, 0.1)).points.empty();
        result.is_doubtful = result.is_noisy && is_clean && cleanness.is_doubtful();
    }
    result.given_noise = options.noise;
    result.noise = options.noise > 0 ? options.noise : cleanness.noise * result.frame.scale();
    result.denoised = options.denoise == Denoise::on || (options.denoise == Denoise::automatic && result.is_noisy);

    if (result.denoised || (options.needs_surface && result.is_noisy))
    {
        times.begin("AMLS");
        result.surface = latest.find(points, sorted, options, progress.part(0.1, 0.7, "AMLS surface"));
        result.noise = result.surface->report().noise;
    }
    if (result.denoised)
    {
        times.begin("projection");
        SurfaceSamples sampled =
            sample_amls_surface(sorted, *result.surface, options.threads, progress.part(0.7, 1, "AMLS projection"));
        result.outliers += sampled.outliers;
        // A point at the origin of a far coordinate system leaves the others a millionth of the frame.
        if (sampled.outliers > 0 && sampled.samples.points.size() >= 4)
            result.choose_frame(sampled.samples.points, points);
        result.samples = result.frame.to_unit(sampled.samples.points);
        result.normals = std::move(sampled.samples.normals);
        result.claimed = std::move(sampled.claimed);
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

} // namespace recon
