#include <recon/crust.h>

#include <recon/collapse_edges.h>
#include <recon/crust_mesh.h>
#include <recon/errors.h>

namespace recon
{

TriangleMesh make_crust(const LabelledBalls& labelled, const CrustOptions& options)
{
    std::vector<int> ball_of_vertex;
    TriangleMesh mesh = extract_crust(labelled.regular, labelled.labels, options.threads, &ball_of_vertex);
    if (mesh.triangles.empty())
        throw AlgorithmFailure(
            "No polar ball inside the surface is left. Lower ball_threshold, or set it to 0 (automatic).");
    if (options.simplify)
    {
        std::vector<double> scale;
        scale.reserve(ball_of_vertex.size());
        for (const int ball : ball_of_vertex)
        {
            const double local = labelled.scale[ball];
            scale.push_back(local > 0 ? local : labelled.spacing);
        }
        EdgeCollapseOptions collapse;
        collapse.target_vertices = options.target_vertices;
        collapse.threads = options.threads;
        collapse_short_edges(mesh, scale, collapse);
    }
    // After the collapse, which leaves a tenth of the triangles.
    if (options.keep_components == KeepComponents::largest)
        keep_largest_component(mesh);
    return mesh;
}

} // namespace recon
