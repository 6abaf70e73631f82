#include "reconstruct.h"

#include "filter_amls/mesh/smooth_mesh.h"
#include "filter_noisy_powercrust/edges/sharp_edges.h"
#include "filter_noisy_powercrust/labels/label_cloud.h"

#include <recon/bare_faces/bare_faces.h>
#include <recon/crust/lids.h>
#include <recon/crust/weaving.h>
#include <recon/errors.h>
#include <recon/labelling/labelled_balls.h>
#include <recon/mesh/convex_surface.h>
#include <recon/mesh/crust_mesh.h>
#include <recon/mesh/mismatch.h>
#include <recon/mesh/taut_closing.h>
#include <recon/mesh/trim.h>
#include <recon/parallel.h>
#include <recon/scan/viewpoint.h>
#include <recon/search/nearest_samples.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

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
    if (!(options.trim_length >= 0) || !std::isfinite(options.trim_length))
        throw InvalidInput("trim_length must be 0 (keep the surface closed) or a positive length.");
    if (!(options.deep_intersection >= 0 && options.deep_intersection <= 1))
        throw InvalidInput("deep_intersection must lie between 0 (weighed in samples) and 1.");
}

/// Share of the points that the crust misses, in the frame of its samples and closed; 0 where votes say that there are
/// next to none, or the points are noisy and were to stay so: how far from the crust they lie then tells nothing.
double measure_missed(const TriangleMesh& mesh, const LabelledCloud& found, int threads, const Progress& progress)
{
    const PreparedSamples& cloud = found.cloud;
    if (found.labelled.violated_votes <= suspicious_votes || (cloud.is_noisy && !cloud.denoised))
        return 0;
    if (!cloud.denoised)
        return measure_missed_points(cloud.samples, mesh, threads, progress);
    return measure_missed_points(points_at(cloud.claimed, cloud.distinct), mesh, threads, progress,
                                 cloud.surface->report().most_noise / cloud.frame.scale());
}

void warn(NoisyPowerCrust& result, const DroppedBodies& dropped, const LabelledCloud& found, Denoise denoise,
          std::size_t points, double missed)
{
    if (found.lost_walls)
        result.warnings.push_back(std::string(lost_walls_text) +
                                  " Set noise to what the scanner has, or scan more densely.");
    if (found.is_between_sheets)
        result.warnings.push_back(out_of_register_text);
    if (found.has_filled_faces)
        result.warnings.push_back(filled_faces_text);
    if (const std::string text = describe_thin_walls(found.opened, found.found_walls, result.violated_votes);
        !text.empty())
        result.warnings.push_back(text);
    if (const std::string text = describe_lost_sheets(found.lost_sheets, found.backs, denoise, points); !text.empty())
        result.warnings.push_back(text);
    if (const std::string text = describe(dropped); !text.empty())
        result.warnings.push_back(text);
    if (const std::string text = describe_violation(result.violated_votes); !text.empty())
        result.warnings.push_back(text);
    // Those of bodies that were left out are known.
    if (const std::string text = describe_missed(missed - dropped.samples); !text.empty() && result.warnings.empty())
        result.warnings.push_back(text);
}

SamplePreparationOptions options_for_samples(const NoisyPowerCrustOptions& options)
{
    SamplePreparationOptions result;
    result.denoise = options.denoise;
    result.noise = options.noise;
    result.needs_surface = options.smooth;
    result.threads = options.threads;
    return result;
}

BallLabellingOptions options_for_balls(const NoisyPowerCrustOptions& options)
{
    BallLabellingOptions result;
    result.ball_threshold = options.ball_threshold;
    result.noise = options.noise;
    result.deep_intersection = options.deep_intersection;
    if (options.simplify && options.ball_threshold == 0)
        result.sharing = BallSharing::undisputed;
    result.threads = resolve_threads(options.threads);
    return result;
}

/// \throws AlgorithmFailure if a threshold of the user's left no labels worth the name.
void report_labels(const LabelledCloud& found, const NoisyPowerCrustOptions& options, NoisyPowerCrust& result)
{
    const PreparedSamples& cloud = found.cloud;
    const LabelledBalls& labelled = found.labelled;
    result.points_used = int(cloud.distinct.size());
    result.samples = int(cloud.samples.size());
    result.completed = found.completed;
    result.outliers = cloud.outliers;
    result.cleanness = cloud.cleanness;
    result.denoised = cloud.denoised;
    result.noise = cloud.noise;
    result.balls_kept = int(labelled.kept.balls.size());
    result.violated_votes = labelled.violated_votes;
    result.spacing = labelled.spacing * cloud.frame.scale();
    double smallest = labelled.kept.balls.front().radius;
    for (const Ball& ball : labelled.kept.balls)
        smallest = std::min(smallest, ball.radius);
    result.smallest_ball = smallest * cloud.frame.scale();
    if (options.ball_threshold > 0 && result.violated_votes > 0.5)
        throw AlgorithmFailure(
            "With this ball_threshold hardly any polar ball inside the surface is left: most points contradict "
            "what remains. Lower ball_threshold, or set it to 0 (automatic).");
}

/// The crust, closed, in the frame of its samples. \param result gets the mesh and its vertices on edges. \throws
/// AlgorithmFailure if it encloses no volume.
DroppedBodies make_surface(LabelledCloud& found, const Points& points, const NoisyPowerCrustOptions& options,
                           NoisyPowerCrust& result, PhaseTimes& times, const Progress& progress)
{
    const PreparedSamples& cloud = found.cloud;
    times.begin("crust");
    CrustOptions crust;
    crust.keep_components = options.keep_components;
    crust.simplify = options.simplify;
    crust.target_vertices = int(cloud.samples.size());
    // Clean samples lie on the surface, denoised ones on the AMLS surface.
    const bool through_samples = options.simplify && (cloud.denoised ? options.smooth : !cloud.is_noisy);
    if (through_samples)
        crust.interpolated = &cloud.samples;
    crust.threads = resolve_threads(options.threads);
    crust.find_viewpoints = [&]
    { return find_viewpoints(points, crust.threads, progress.part(0, 0, "places of scanners")).in(cloud.frame); };
    TriangleMesh& mesh = result.mesh;
    DroppedBodies dropped;
    mesh = make_crust(std::move(found.list_polygons(crust.threads)), found.labelled, crust,
                      progress.part(0, 0.75, "crust"), &dropped);
    if (options.smooth && cloud.surface && !through_samples)
    {
        times.begin("smooth");
        cloud.frame.from_unit_in_place(mesh.vertices);
        smooth_mesh(mesh, *cloud.surface, options.threads, progress.part(0.75, 1, "smoothing"));
        mesh.vertices = cloud.frame.to_unit(mesh.vertices);
    }
    if (cloud.denoised && through_samples)
    {
        times.begin("edges");
        result.edge_vertices = restore_sharp_edges(mesh, points_at(cloud.claimed, cloud.distinct), crust.threads,
                                                   progress.part(0.75, 1, "sharp edges"));
    }
    if (options.smooth)
    {
        times.begin("closing");
        draw_bare_faces_taut(mesh, cloud.samples, crust.threads);
    }
    check_encloses_volume(mesh);
    return dropped;
}

/// What was asked to be open is opened. \throws AlgorithmFailure if nothing is left.
void open_surface(TriangleMesh& mesh, const LabelledCloud& found, const Points& points,
                  const NoisyPowerCrustOptions& options, const Progress& progress)
{
    if (!(options.trim_length > 0) && !options.open_holes)
        return;
    const PreparedSamples& cloud = found.cloud;
    const int threads = resolve_threads(options.threads);
    const Viewpoints viewpoints =
        find_viewpoints(points, threads, progress.part(0, 0.2, "places of scanners")).in(cloud.frame);
    if (options.trim_length > 0)
        trim_by_length(mesh, cloud.distinct, options.trim_length / cloud.frame.scale(), threads,
                       progress.part(0.2, 1, "trimming"), viewpoints);
    else
        open_holes(mesh, cloud.samples, found.backs, threads, progress.part(0.2, 1, "holes"), viewpoints);
    if (mesh.triangles.empty())
        throw AlgorithmFailure(
            "No part of the crust is within trim_length of a point. Raise trim_length, or set it to 0.");
}

void report_topology(const NoisyPowerCrustOptions& options, NoisyPowerCrust& result)
{
    const bool is_closed = !options.open_holes && options.trim_length == 0;
    const Topology topology = is_closed ? measure_closed_topology(result.mesh) : measure_topology(result.mesh);
    result.components = topology.components;
    result.boundary_loops = topology.boundary_loops;
    result.euler_characteristic = topology.euler_characteristic;
    result.genus = topology.genus();
}

/// Unless something is asked for that the hull has not.
std::optional<ConvexSurface> find_hull(const Points& points, const NoisyPowerCrustOptions& options)
{
    const bool is_asked = options.denoise == Denoise::on || options.noise > 0 || options.ball_threshold > 0 ||
                          options.deep_intersection > 0 || options.open_holes || options.trim_length > 0;
    if (is_asked || points.size() > most_points_on_hull)
        return {};
    check_spans_volume(points);
    resolve_threads(options.threads); // throws
    return find_convex_surface(points);
}

NoisyPowerCrust take_hull(ConvexSurface hull)
{
    const double spacing = hull.spacing;
    NoisyPowerCrust result = result_of<NoisyPowerCrust>(std::move(hull));
    result.points_used = result.samples;
    result.spacing = spacing;
    result.cleanness = 1;
    return result;
}

NoisyPowerCrust reconstruct(const Points& points, const NoisyPowerCrustOptions& options, const Progress& progress)
{
    NoisyPowerCrust result;
    PhaseTimes times;
    const BallLabellingOptions labelling = options_for_balls(options);
    LabelledCloud found =
        label_cloud(points, options_for_samples(options), labelling, times, progress.part(0, 0.75, "crust"));
    report_labels(found, options, result);
    const DroppedBodies dropped = make_surface(found, points, options, result, times, progress.part(0.75, 0.95));
    times.begin("finish");
    const double missed = measure_missed(result.mesh, found, labelling.threads, progress.part(0.95, 0.96, "points"));
    open_surface(result.mesh, found, points, options, progress.part(0.96, 0.97));
    const NearestSamples nearest = find_nearest_samples(result.mesh.vertices, found.cloud.distinct, labelling.threads,
                                                        progress.part(0.97, 1, "nearest points"));
    for (const int sample : nearest.sample)
        result.nearest_sample.push_back(found.cloud.order[sample]);
    report_topology(options, result);
    found.cloud.frame.from_unit_in_place(result.mesh.vertices);
    warn(result, dropped, found, options.denoise, points.size(), missed);
    times.end();
    result.seconds = times.seconds();
    return result;
}

} // namespace

NoisyPowerCrust reconstruct_noisy_power_crust(const Points& points, const NoisyPowerCrustOptions& options,
                                              const Progress& progress)
{
    const ThreadTeam team;
    check(options);
    return hull_or(
        find_hull(points, options), [&] { return reconstruct(points, options, progress); }, take_hull);
}

} // namespace recon
