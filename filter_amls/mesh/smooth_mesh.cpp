#include "smooth_mesh.h"

#include "filter_amls/surface/project.h"

#include <Eigen/Geometry>

#include <algorithm>

namespace recon
{

std::vector<char> smooth_mesh(TriangleMesh& mesh, const AmlsSurface& surface, int threads, const Progress& progress,
                              const std::vector<char>& stays)
{
    AmlsProjectionOptions options;
    options.threads = threads;
    options.foreign_points = true;
    const AmlsProjection projected = project_to_amls(mesh.vertices, surface, options, progress);
    const std::size_t n = mesh.vertices.size();
    std::vector<double> share(n, 1);
    for (std::size_t v = 0; v < n; ++v)
    {
        // Farther than noise and spacing explain, the surface is extrapolated over a bare flat, or the other side of a
        // wall.
        const double moved = (projected.points[v] - mesh.vertices[v]).norm();
        const double explained = std::max(projected.spacings[v], 3 * surface.report().noise);
        const bool is_asked = stays.empty() || !stays[v];
        if (!is_asked || projected.status[v] != ProjectionStatus::converged || !(moved < explained))
            share[v] = 0;
    }
    const auto position = [&](int v) -> Point
    { return mesh.vertices[v] + share[v] * (projected.points[v] - mesh.vertices[v]); };
    const int rounds = 4;
    for (int round = 0; round < rounds; ++round)
    {
        std::vector<char> reduce(n, 0);
        bool any = false;
        for (const auto& t : mesh.triangles)
        {
            const auto normal = [](const Point& a, const Point& b, const Point& c) -> Vector
            { return (b - a).cross(c - a); };
            const Vector before = normal(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]);
            const Vector after = normal(position(t[0]), position(t[1]), position(t[2]));
            if (before.dot(after) > 0)
                continue;
            // Slivers may turn as long as they end up facing as the surface does.
            const Vector outward = projected.normals[t[0]] + projected.normals[t[1]] + projected.normals[t[2]];
            if (after.dot(outward) > 0)
                continue;
            for (const int v : t)
                if (share[v] > 0)
                {
                    reduce[v] = 1;
                    any = true;
                }
        }
        if (!any)
            break;
        for (std::size_t v = 0; v < n; ++v)
            if (reduce[v])
                share[v] = round + 2 < rounds ? 0.5 * share[v] : 0;
    }
    std::vector<char> moved(n, 0);
    for (std::size_t v = 0; v < n; ++v)
        if (share[v] > 0)
        {
            mesh.vertices[v] = position(int(v));
            moved[v] = 1;
        }
    return moved;
}

} // namespace recon
