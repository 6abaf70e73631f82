// Registered scans against the surface made of them: amls_scans <scan> <mesh> [<scan> <mesh>...]. RMS distances in 1e-6
// of the mesh's diagonal; oriented: result normals that agree with the nearest triangle's. Left out are outliers, and
// points farther than 1 % of the diagonal, of which the mesh has nothing.
#include "mesh_distance.h"
#include "models.h"

#include "filter_amls/surface/project.h"

#include <Eigen/Geometry>

#include <cmath>
#include <cstdio>

using namespace recon;

constexpr double farthest = 0.01; // diagonals

int main(int argc, char** argv)
{
    std::printf("| scan | points | RMS before | after | oriented | outliers | strange | open | CPU s "
                "|\n|---|---|---|---|---|---|---|---|---|\n");
    for (int i = 1; i + 1 < argc; i += 2)
    {
        const Points points = benchmarks::load_model(argv[i]).mesh.vertices;
        const benchmarks::Model mesh = benchmarks::load_model(argv[i + 1]);
        const benchmarks::MeshDistance truth(mesh.mesh);
        AmlsOptions options;
        options.threads = 1;
        AmlsProjectionOptions project_options;
        project_options.threads = 1;
        const double begin = benchmarks::cpu_seconds();
        const AmlsSurface surface = build_amls_surface(points, options);
        const AmlsProjection projection = project_to_amls(points, surface, project_options);
        const double seconds = benchmarks::cpu_seconds() - begin;
        double before = 0, after = 0;
        std::size_t right = 0, asked = 0, strange = 0;
        for (std::size_t k = 0; k < points.size(); ++k)
        {
            if (projection.status[k] == ProjectionStatus::outlier)
                continue;
            const auto nearest = truth.nearest(projection.points[k]);
            const double was = truth.nearest(points[k]).distance;
            if (was > farthest * mesh.diagonal)
            {
                ++strange;
                continue;
            }
            before += was * was;
            after += std::pow(nearest.distance, 2);
            const auto& t = mesh.mesh.triangles[std::size_t(nearest.triangle)];
            const Vector a = mesh.mesh.vertices[t[1]] - mesh.mesh.vertices[t[0]],
                         b = mesh.mesh.vertices[t[2]] - mesh.mesh.vertices[t[0]];
            right += a.cross(b).dot(projection.normals[k]) > 0;
            ++asked;
        }
        const double n = double(asked), unit = 1e6 / mesh.diagonal;
        std::printf("| %s | %zu | %.0f | %.0f | %.5f | %zu | %zu | %s | %.1f |\n", argv[i], points.size(),
                    unit * std::sqrt(before / n), unit * std::sqrt(after / n), double(right) / n,
                    points.size() - asked - strange, strange, surface.report().open ? "yes" : "no", seconds);
        std::fflush(stdout);
    }
}
