#include "reconstruct.h"

#include "filter_amls/sample_surface.h"
#include "filter_amls/surface.h"

#include <recon/crust_mesh.h>
#include <recon/errors.h>
#include <recon/labelled_balls.h>
#include <recon/neighbours.h>
#include <recon/noise.h>
#include <recon/parallel.h>
#include <recon/spatial_order.h>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

void check(const NoisyPowerCrustOptions& options)
{
    if (!(options.ball_threshold >= 0) || !std::isfinite(options.ball_threshold))
        throw InvalidInput("ball_threshold must be 0 (automatic) or a positive length.");
    if (!(options.noise >= 0) || !std::isfinite(options.noise))
        throw InvalidInput("noise must be 0 (estimate) or a positive length.");
    if (!(options.deep_intersection >= 0 && options.deep_intersection <= 1))
        throw InvalidInput("deep_intersection must lie between 0 (weighed in samples) and 1.");
}

/// Distinct points in the unit frame, in spatial order: neighbours in space are neighbours in memory, and every stride is
/// an even subset.
Points ordered_unit_points(const Points& points, const UnitFrame& frame)
{
    Points result;
    for (const int i : order_spatially(points).order)
        result.push_back(frame.to_unit(points[i]));
    return result;
}

} // namespace

NoisyPowerCrust reconstruct_noisy_power_crust(const Points& points, const NoisyPowerCrustOptions& options,
                                              const Progress& progress)
{
    check(options);
    check_spans_volume(points);
    const UnitFrame frame(points);

    NoisyPowerCrust result;
    PhaseTimes times;
    BallLabellingOptions labelling;
    labelling.ball_threshold = options.ball_threshold / frame.scale();
    labelling.noise = options.noise / frame.scale();
    labelling.deep_intersection = options.deep_intersection;
    labelling.threads = resolve_threads(options.threads);

    Points samples;
    Vectors normals;
    result.denoised = options.denoise == Denoise::on;
    if (result.denoised)
    {
        times.begin("AMLS");
        AmlsOptions amls;
        amls.noise = options.noise;
        amls.threads = options.threads;
        const AmlsSurface surface = build_amls_surface(points, amls, progress.part(0, 0.2, "AMLS"));
        SurfaceSamples sampled = sample_amls_surface(points, surface, options.threads, progress.part(0.2, 0.3, "AMLS"));
        samples = frame.to_unit(sampled.samples.points);
        normals = std::move(sampled.samples.normals);
        result.outliers = sampled.outliers;
        result.noise = surface.report().noise;
        result.points_used = int(points.size());
    }
    else
    {
        times.begin("order");
        samples = ordered_unit_points(points, frame);
        result.points_used = int(samples.size());
    }
    result.samples = int(samples.size());
    const LabelledBalls labelled =
        label_polar_balls(std::move(samples), normals, labelling, times, progress.part(0.3, 0.9, "crust"));
    result.balls_kept = int(labelled.kept.balls.size());
    result.violated_votes = labelled.violated_votes;
    result.spacing = labelled.spacing * frame.scale();

    times.begin("crust");
    result.mesh = extract_crust(labelled.diagram, labelled.regular, labelled.kept.balls, labelled.labels);
    if (result.mesh.triangles.empty())
        throw AlgorithmFailure("No polar ball inside the surface is left. Lower ball_threshold, or set it to 0 (automatic).");
    if (options.keep_components == KeepComponents::largest)
        keep_largest_component(result.mesh);
    result.components = find_components(result.mesh).count;
    result.euler_characteristic = euler_characteristic(result.mesh);
    result.genus = result.components - result.euler_characteristic / 2;
    times.end();
    frame.from_unit_in_place(result.mesh.vertices);
    result.seconds = times.seconds();
    return result;
}

} // namespace recon
