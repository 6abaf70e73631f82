#include "reconstruct_amls.h"

#include "label_points.h"
#include "smooth_mesh.h"

#include <recon/back_sheets.h>
#include <recon/crust_mesh.h>
#include <recon/mismatch.h>
#include <recon/neighbours.h>
#include <recon/parallel.h>
#include <recon/taut_closing.h>
#include <recon/trim.h>

#include <algorithm>

namespace recon
{
namespace
{

/// Whether bare lids seem to close what walls hold that were taken for noise.
bool seems_filled(const Points& points, const TriangleMesh& mesh, const LabelledSamples& found, double noise,
                  int threads)
{
    const TriangleMesh crust{found.frame.to_unit(mesh.vertices), mesh.triangles, {}};
    if (noise < least_noise_of_walls * found.labelled.spacing * found.frame.scale() ||
        measure_bare_area(found.samples, crust, threads) <= bare_lid)
        return false;
    const Points claimed = found.frame.to_unit(points_at(found.claimed, points));
    return !measure_noise_misfit(claimed, crust, noise / found.frame.scale(), threads).is_noise();
}

/// Over holes of the scan. \param is_on_surface loses the vertices that move.
void draw_closings_taut(TriangleMesh& mesh, const LabelledSamples& found, std::vector<char>& is_on_surface, int threads)
{
    const Points before = found.frame.to_unit(mesh.vertices);
    TriangleMesh taut{before, mesh.triangles, {}};
    if (draw_bare_faces_taut(taut, found.samples, threads) == 0)
        return;
    for (std::size_t v = 0; v < before.size(); ++v)
        if (taut.vertices[v] != before[v])
        {
            is_on_surface[v] = 0;
            mesh.vertices[v] = found.frame.from_unit(taut.vertices[v]);
        }
}

/// \param is_on_surface loses the vertices that go.
void open_amls_holes(TriangleMesh& mesh, const LabelledSamples& found, std::vector<char>& is_on_surface, int threads,
                     const Progress& progress)
{
    Points samples = found.samples;
    found.frame.from_unit_in_place(samples);
    std::vector<char> left;
    for (const int former : open_holes(mesh, samples, found.backs, threads, progress))
        left.push_back(is_on_surface[former]);
    is_on_surface = std::move(left);
}

} // namespace

AmlsReconstruction reconstruct_amls(const Points& points, const AmlsReconstructionOptions& options,
                                    const Progress& progress)
{
    AmlsReconstruction result;
    PhaseTimes times;
    times.begin("surface");
    AmlsOptions surface_options;
    surface_options.rho_e = options.rho_e;
    surface_options.noise = options.noise;
    surface_options.threads = options.threads;
    surface_options.terrain_faces_up = false; // see there
    const AmlsSurface surface = build_amls_surface(points, surface_options, progress.part(0, 0.3, "AMLS surface"));
    result.surface = surface.report();

    const BallLabellingOptions labelling = options_for_labels(resolve_threads(options.threads));
    LabelledSamples found =
        label_points(points, surface, options.noise == 0, labelling, times, progress.part(0.3, 0.75, "labels"));
    result.outliers = found.outliers;
    result.samples = int(found.samples.size()) - found.backs;
    result.violated_votes = found.labelled.violated_votes;
    times.begin("crust");
    CrustOptions crust;
    crust.keep_components = options.keep_components;
    crust.simplify = options.simplify;
    crust.target_vertices = int(found.samples.size());
    crust.interpolated = &found.samples;
    crust.threads = labelling.threads;
    DroppedBodies dropped;
    result.mesh = make_crust(found.labelled, crust, progress.part(0.75, 0.85, "crust"), &dropped);
    for (const std::string& text : {describe(dropped), describe_violation(result.violated_votes)})
        if (!text.empty())
            result.warnings.push_back(text);
    if (found.lost_sheets > 0)
        result.warnings.push_back(describe_backs(found.lost_sheets));
    found.frame.from_unit_in_place(result.mesh.vertices);
    std::vector<char> is_on_surface(result.mesh.vertices.size(), 0);
    if (!found.is_exact)
    {
        times.begin("smooth");
        is_on_surface =
            smooth_mesh(result.mesh, surface, options.threads, progress.part(0.85, 0.95, "projection of the mesh"));
        if (seems_filled(points, result.mesh, found, result.surface.noise, labelling.threads))
            result.warnings.push_back(
                std::string(lost_walls_text) +
                " Use the filter Surface Reconstruction: Noisy Power Crust, which looks for such walls.");
    }
    times.begin("closing");
    draw_closings_taut(result.mesh, found, is_on_surface, labelling.threads);
    times.begin("finish");
    if (options.open_holes)
        open_amls_holes(result.mesh, found, is_on_surface, labelling.threads, progress.part(0.95, 0.97, "holes"));
    result.vertices_on_surface = int(std::count(is_on_surface.begin(), is_on_surface.end(), 1));
    const NeighbourSearch search(points);
    result.nearest_sample.resize(result.mesh.vertices.size());
    parallel_for(result.mesh.vertices.size(), labelling.threads, progress.part(0.97, 1, "nearest points"),
                 [&](std::size_t v) { result.nearest_sample[v] = search.nearest(result.mesh.vertices[v]); });
    const Topology topology = options.open_holes ? measure_topology(result.mesh) : measure_closed_topology(result.mesh);
    result.components = topology.components;
    result.boundary_loops = topology.boundary_loops;
    result.euler_characteristic = topology.euler_characteristic;
    result.genus = topology.genus();
    times.end();
    result.seconds = times.seconds();
    return result;
}

} // namespace recon
