#include <recon/crust/crust.h>

#include <recon/errors.h>
#include <recon/mesh/collapse_edges.h>
#include <recon/mesh/crust_mesh.h>
#include <recon/mesh/interpolate_samples.h>
#include <recon/mesh/weld_clusters.h>
#include <recon/search/nearest_samples.h>

#include <cmath>
#include <utility>

namespace recon
{
namespace
{

std::vector<double> list_scales(const CrustPolygons& polygons, const LabelledBalls& labelled)
{
    std::vector<double> result;
    result.reserve(polygons.ball.size());
    for (const int ball : polygons.ball)
    {
        const double local = labelled.scale[ball];
        result.push_back(local > 0 ? local : labelled.spacing);
    }
    return result;
}

/// Where the crust is coarser than the samples, a vertex without a seat is as far from one [scale].
constexpr double farthest_from_seat = 2;

std::string percent(double share)
{
    return std::to_string(int(std::lround(100 * share)));
}

TriangleMesh simplify(CrustPolygons polygons, const LabelledBalls& labelled, const CrustOptions& options,
                      const Progress& progress)
{
    NearestSamples nearest;
    if (options.interpolated)
        nearest = find_nearest_samples(polygons.vertices, *options.interpolated, options.threads);
    WeldedCrust welded = weld_clusters(polygons, list_scales(polygons, labelled),
                                       options.interpolated ? &nearest : nullptr, options.threads);
    polygons = {}; // ten corners a sample: a fifth of the memory of all that follows
    progress.report(0.4);
    TriangleMesh mesh = std::move(welded.mesh);
    EdgeCollapseOptions collapse;
    collapse.target_vertices = options.target_vertices;
    collapse.threads = options.threads;
    std::vector<int> seats;
    if (options.interpolated)
    {
        NearestSamples of_vertices;
        for (const int c : welded.corner)
        {
            of_vertices.sample.push_back(nearest.sample[c]);
            of_vertices.squared.push_back(nearest.squared[c]);
        }
        seats = seat_samples(of_vertices, options.interpolated->size());
        collapse.never_above = farthest_from_seat;
        for (const int sample : seats)
            collapse.stays.push_back(sample >= 0);
    }
    const std::vector<int> former =
        collapse_short_edges(mesh, welded.half_edges, welded.scale, welded.merged, collapse);
    progress.report(0.8);
    if (options.interpolated)
    {
        std::vector<int> seats_left;
        for (const int vertex : former)
            seats_left.push_back(seats[vertex]);
        interpolate_samples(mesh, seats_left, *options.interpolated, options.threads);
    }
    return mesh;
}

} // namespace

TriangleMesh make_crust(const LabelledBalls& labelled, const CrustOptions& options, const Progress& progress,
                        DroppedBodies* dropped)
{
    return make_crust(list_crust_polygons(labelled.regular, labelled.labels, options.threads), labelled, options,
                      progress, dropped);
}

TriangleMesh make_crust(CrustPolygons polygons, const LabelledBalls& labelled, const CrustOptions& options,
                        const Progress& progress, DroppedBodies* dropped)
{
    if (polygons.corners.empty())
        throw AlgorithmFailure("No polar ball inside the surface is left. Lower ball_threshold if it is not 0 "
                               "(automatic); if it is, the points are too few or too scattered for a surface.");
    progress.report(0.2);
    TriangleMesh mesh = options.simplify ? simplify(std::move(polygons), labelled, options, progress)
                                         : triangulate_polygons(polygons, options.threads);
    // After the collapse, which leaves a tenth of the triangles.
    constexpr double root_of_area = 0.7; // over the median distance of neighbours, on evenly sampled surfaces
    const DroppedBodies bodies =
        drop_components(mesh, options.keep_components, root_of_area * labelled.spacing, options.find_viewpoints);
    if (dropped)
        *dropped = bodies;
    progress.report(1);
    return mesh;
}

std::string describe(const DroppedBodies& dropped)
{
    constexpr double volume_worth_a_word = 0.05, samples_worth_a_word = 0.02;
    if (dropped.volume < volume_worth_a_word && dropped.samples < samples_worth_a_word)
        return {};
    return std::to_string(dropped.count) + (dropped.count == 1 ? " other body was" : " other bodies were") +
           " left out, with " + percent(dropped.volume) + " % of the volume of the largest and " +
           percent(dropped.samples) + " % of the samples. To keep all, set keep_components to all.";
}

std::string describe_violation(double violated_votes)
{
    constexpr double safe = 0.05; // above, right results were rare in trials
    if (violated_votes <= safe)
        return {};
    return "The points contradict the surface in " + percent(violated_votes) +
           " % of their votes: parts are probably missing or filled. Walls may be thinner than the spacing or the "
           "noise of the points; look at the result, and scan such parts more densely.";
}

} // namespace recon
