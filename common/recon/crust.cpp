#include <recon/crust.h>

#include <recon/collapse_edges.h>
#include <recon/crust_mesh.h>
#include <recon/errors.h>

#include <numeric>

namespace recon
{

TriangleMesh make_crust(const LabelledBalls& labelled, const CrustOptions& options)
{
    std::vector<int> ball_of_vertex;
    TriangleMesh mesh = extract_crust(labelled.regular, labelled.labels, &ball_of_vertex);
    if (mesh.triangles.empty())
        throw AlgorithmFailure("No polar ball inside the surface is left. Lower ball_threshold, or set it to 0 (automatic).");
    std::vector<int> former(mesh.vertices.size());
    std::iota(former.begin(), former.end(), 0);
    if (options.keep_components == KeepComponents::largest)
        former = keep_largest_component(mesh);
    if (options.simplify)
    {
        std::vector<double> scale;
        scale.reserve(former.size());
        for (const int v : former)
        {
            const double local = labelled.scale[ball_of_vertex[v]];
            scale.push_back(local > 0 ? local : labelled.spacing);
        }
        EdgeCollapseOptions collapse;
        collapse.target_vertices = options.target_vertices;
        collapse_short_edges(mesh, scale, collapse);
    }
    return mesh;
}

} // namespace recon
