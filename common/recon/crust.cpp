#include <recon/crust.h>

#include <recon/collapse_edges.h>
#include <recon/crust_mesh.h>
#include <recon/errors.h>
#include <recon/interpolate_samples.h>
#include <recon/weld_clusters.h>

#include <utility>

namespace recon
{
TriangleMesh make_crust(const LabelledBalls& labelled, const CrustOptions& options)
{
    const CrustPolygons polygons = list_crust_polygons(labelled.regular, labelled.labels, options.threads);
    if (polygons.corners.empty())
        throw AlgorithmFailure(
            "No polar ball inside the surface is left. Lower ball_threshold, or set it to 0 (automatic).");
    TriangleMesh mesh;
    if (options.simplify)
    {
        std::vector<double> scale;
        scale.reserve(polygons.ball.size());
        for (const int ball : polygons.ball)
        {
            const double local = labelled.scale[ball];
            scale.push_back(local > 0 ? local : labelled.spacing);
        }
        WeldedCrust welded = weld_clusters(polygons, scale, options.threads);
        mesh = std::move(welded.mesh);
        EdgeCollapseOptions collapse;
        collapse.target_vertices = options.target_vertices;
        collapse.threads = options.threads;
        std::vector<int> seats;
        if (options.interpolated)
        {
            seats = seat_samples(mesh.vertices, *options.interpolated, options.threads);
            for (const int sample : seats)
                collapse.stays.push_back(sample >= 0);
        }
        const std::vector<int> former =
            collapse_short_edges(mesh, welded.half_edges, welded.scale, welded.merged, collapse);
        if (options.interpolated)
        {
            std::vector<int> seats_left;
            for (const int vertex : former)
                seats_left.push_back(seats[vertex]);
            interpolate_samples(mesh, seats_left, *options.interpolated, options.threads);
        }
    }
    else
        mesh = triangulate_polygons(polygons, options.threads);
    // After the collapse, which leaves a tenth of the triangles.
    if (options.keep_components == KeepComponents::largest)
        keep_largest_component(mesh);
    return mesh;
}

} // namespace recon
