#include "reconstruct_amls.h"

#include "sample_surface.h"
#include "smooth_mesh.h"

#include <recon/crust_mesh.h>
#include <recon/errors.h>
#include <recon/neighbours.h>
#include <recon/parallel.h>

namespace recon
{

AmlsReconstruction reconstruct_amls(const Points& points, const AmlsReconstructionOptions& options,
                                    const Progress& progress)
{
    AmlsReconstruction result;
    PhaseTimes times;
    times.begin("surface");
    const AmlsSurface surface = build_amls_surface(points, options, progress.part(0, 0.3, "AMLS surface"));
    result.surface = surface.report();
    times.begin("projection");
    SurfaceSamples sampled =
        sample_amls_surface(points, surface, options.threads, progress.part(0.3, 0.4, "AMLS projection"));
    result.samples = int(sampled.samples.points.size());
    result.outliers = sampled.outliers;
    if (result.samples < 4)
        throw AlgorithmFailure("No surface was found among the points: all but " + std::to_string(result.samples) +
                               " are isolated. Use a denser cloud, or select the part to reconstruct.");

    const UnitFrame frame(points);
    BallLabellingOptions labelling;
    labelling.threads = resolve_threads(options.threads);
    const Points samples = frame.to_unit(sampled.samples.points);
    const LabelledBalls labelled =
        label_polar_balls(samples, sampled.samples.normals, labelling, times, progress.part(0.4, 0.75, "polar balls"));
    result.violated_votes = labelled.violated_votes;
    times.begin("crust");
    CrustOptions crust;
    crust.keep_components = options.keep_components;
    crust.simplify = options.simplify;
    crust.target_vertices = result.samples;
    crust.interpolated = &samples;
    crust.threads = labelling.threads;
    result.mesh = make_crust(labelled, crust, progress.part(0.75, 0.85, "crust"));
    frame.from_unit_in_place(result.mesh.vertices);
    times.begin("smooth");
    result.vertices_on_surface =
        smooth_mesh(result.mesh, surface, options.threads, progress.part(0.85, 0.95, "projection of the mesh"));
    times.begin("finish");
    const NeighbourSearch search(points);
    result.nearest_sample.resize(result.mesh.vertices.size());
    parallel_for(result.mesh.vertices.size(), labelling.threads, progress.part(0.95, 1, "nearest points"),
                 [&](std::size_t v) { result.nearest_sample[v] = search.nearest(result.mesh.vertices[v]); });
    const Topology topology = measure_closed_topology(result.mesh);
    result.components = topology.components;
    result.euler_characteristic = topology.euler_characteristic;
    result.genus = topology.genus();
    times.end();
    result.seconds = times.seconds();
    return result;
}

} // namespace recon
