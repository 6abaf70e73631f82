#include "reconstruct.h"

#include <recon/ball_attraction.h>
#include <recon/crust_mesh.h>
#include <recon/crust_repair.h>
#include <recon/delaunay.h>
#include <recon/errors.h>
#include <recon/ball_scale.h>
#include <recon/neighbours.h>
#include <recon/opposite_votes.h>
#include <recon/parallel.h>
#include <recon/polar_balls.h>
#include <recon/power_diagram.h>
#include <recon/signed_labelling.h>
#include <recon/spatial_order.h>

#include <algorithm>
#include <cmath>
#include <optional>

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
    result.reserve(points.size() + box_corner_count);
    for (const int i : order_spatially(points).order)
        result.push_back(frame.to_unit(points[i]));
    return result;
}

/// Mean over the samples that a ball touches, corners of the box left out.
std::vector<double> average_over_touched(const PolarBalls& balls, const std::vector<double>& per_sample)
{
    std::vector<double> result;
    result.reserve(balls.balls.size());
    for (const auto& touched : balls.touched)
    {
        double sum = 0;
        int count = 0;
        for (const int v : touched)
            if (v < int(per_sample.size()))
            {
                sum += per_sample[v];
                ++count;
            }
        result.push_back(count > 0 ? sum / count : 0);
    }
    return result;
}

std::vector<SignedEdge> concatenate(const std::vector<SignedEdge>& a, const std::vector<SignedEdge>& b)
{
    std::vector<SignedEdge> result = a;
    result.insert(result.end(), b.begin(), b.end());
    return result;
}

} // namespace

NoisyPowerCrust reconstruct_noisy_power_crust(const Points& points, const NoisyPowerCrustOptions& options,
                                              const Progress& progress)
{
    check(options);
    const int threads = resolve_threads(options.threads);
    const UnitFrame frame(points);
    check_spans_volume(points);

    NoisyPowerCrust result;
    PhaseTimes times;
    times.begin("delaunay");
    Points samples = ordered_unit_points(points, frame);
    result.points_used = int(samples.size());
    const Points free_samples = samples; // without the corners of the box
    append_box_corners(samples);

    // Step 1 beside the local spacing, which needs no triangulation.
    Triangulation delaunay;
    std::optional<NeighbourSearch> search;
    SampleSpacing spacing;
    parallel_invoke(
        threads, [&] { delaunay = triangulate_delaunay(samples, progress.part(0, 0.3, "Delaunay triangulation")); },
        [&]
        {
            search.emplace(free_samples);
            spacing = measure_spacing(free_samples, *search, 1);
        });

    times.begin("polar balls");
    const Poles poles = find_poles(delaunay, samples);
    const BallScale scale = choose_scale(spacing, free_samples, delaunay, poles);
    const double fixed_threshold = options.ball_threshold / frame.scale();
    const PolarBalls kept = keep_polar_balls(delaunay, samples, poles,
                                             [&](double radius, const std::array<int, 4>& touched)
                                             {
                                                 if (fixed_threshold > 0)
                                                     return radius >= fixed_threshold;
                                                 double sum = 0;
                                                 int count = 0;
                                                 for (const int v : touched)
                                                     if (v < result.points_used)
                                                     {
                                                         sum += scale.threshold[v];
                                                         ++count;
                                                     }
                                                 return count == 0 || radius * count >= sum;
                                             });
    const std::vector<double> ball_scale = average_over_touched(kept, scale.scale);
    const std::vector<double> ball_density = average_over_touched(kept, scale.density);
    delaunay = Triangulation();
    result.balls_kept = int(kept.balls.size());
    progress.part(0.3, 0.35, "polar balls").report(1);

    times.begin("power diagram");
    PowerDiagram diagram(kept.balls, progress.part(0.35, 0.5, "power diagram"));
    Triangulation regular = diagram.triangulation();

    times.begin("labels");
    BallAttractionOptions attraction_options;
    attraction_options.deep_intersection = options.deep_intersection;
    attraction_options.threads = threads;
    const BallAttraction attraction =
        weigh_attraction(regular, kept.balls, ball_density, attraction_options, progress.part(0.5, 0.6, "attraction of balls"));
    const std::vector<SignedEdge> votes =
        list_opposite_votes(samples, kept, *search, threads, progress.part(0.6, 0.7, "votes of the samples"));
    SignedGraph graph;
    graph.nodes = int(kept.balls.size());
    graph.edges = concatenate(attraction.edges, votes);
    graph.merged = attraction.merged;
    graph.is_root = kept.is_outside;
    for (int i = 0; i < graph.nodes; ++i)
        graph.is_root[i] |= attraction.is_on_hull[i];
    std::vector<Side> labels = label_by_contraction(graph);
    std::vector<Side> by_potential = label_by_potential(graph);
    if (measure_energy(graph, by_potential) < measure_energy(graph, labels))
        labels = std::move(by_potential);
    result.violated_votes = measure_violated_repulsion(votes, labels).share();
    progress.part(0.7, 0.8, "labels").report(1);

    times.begin("repair");
    const std::vector<double> margins = measure_margins(graph, labels);
    std::vector<char> is_small(kept.balls.size());
    std::vector<int> doubtful;
    for (int i = 0; i < graph.nodes; ++i)
    {
        is_small[i] = kept.balls[i].radius < 2 * ball_scale[i];
        if (is_small[i] && margins[i] < 0.6 && !kept.is_outside[i])
            doubtful.push_back(i);
    }
    if (!doubtful.empty())
    {
        diagram.remove(doubtful);
        regular = diagram.triangulation();
    }
    // The second round sees what the first joined.
    for (int round = 0; round < 2 && absorb_islands(regular, graph.is_root, 0.02, labels) > 0; ++round)
        continue;
    cut_handles(regular, graph.is_root, is_small, margins, {}, labels);
    progress.part(0.8, 0.9, "repair").report(1);

    times.begin("crust");
    // Removal can bring other balls to the hull; outside is all that is known there.
    for (std::size_t c = std::size_t(regular.finite_cells); c < regular.cells.size(); ++c)
        for (const int v : regular.cells[c].vertices)
            if (v != Triangulation::infinite)
                labels[v] = Side::outer;
    result.mesh = extract_crust(diagram, regular, kept.balls, labels);
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
