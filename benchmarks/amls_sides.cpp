// Sides of thin walls, and of the vertices of coarse models.
// amls_sides <seed> [--noise percent,...] [model.ply...]
// Without models one Markdown row per tube of thin walls: share of samples whose normal is right (filter "Compute
// normals"), volume over the true one of AMLS's reconstruction and of the power crust. With models one row each, of
// their vertices as they are, or with four copies under so much noise (of the diagonal): share right and mean angle
// [degrees] of the AMLS surface's normals and of the filter's, against the mesh's at the vertex.
#include "models.h"

#include "filter_amls/mesh/reconstruct_amls.h"
#include "filter_amls/normals/outward_normals.h"
#include "filter_amls/surface/project.h"
#include "filter_noisy_powercrust/reconstruct.h"
#include "tests/checks.h"
#include "tests/shapes.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

using namespace benchmarks;
using namespace recon;

namespace
{

/// As noisy_cloud() makes them, without those whose vertex has no triangles.
OrientedSamples list_samples(const Model& model, double percent, unsigned seed)
{
    const Vectors normals = vertex_normals(model.mesh);
    const Points points = noisy_cloud(model, percent, seed);
    const std::size_t vertices = normals.size(), copies = points.size() / vertices - 1;
    OrientedSamples result;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (const Vector& normal = normals[i < vertices ? i : (i - vertices) / copies]; normal.norm() > 1e-9)
        {
            result.points.push_back(points[i]);
            result.normals.push_back(std::copysign(1, model.volume) * normal.normalized());
        }
    return result;
}

void print_model(const std::string& path, double percent, unsigned seed)
{
    const OrientedSamples samples = list_samples(load_model(path), percent, seed);
    const Vectors of_surface = project_to_amls(samples.points, build_amls_surface(samples.points)).normals;
    const OutwardNormals found = find_outward_normals(samples.points);
    std::printf("| %s | %g | %zu | %.5f | %.1f | %.5f | %.1f | %s |\n", std::filesystem::path(path).stem().c_str(),
                percent, samples.points.size(), checks::share_facing(of_surface, samples.normals),
                checks::mean_angle(of_surface, samples.normals), checks::share_facing(found.normals, samples.normals),
                checks::mean_angle(found.normals, samples.normals), found.is_exact ? "yes" : "no");
    std::fflush(stdout);
}

/// \param wall, noise [spacings]
void print_tube(double wall, double noise, unsigned seed)
{
    const shapes::Pipe tube = shapes::pipe(wall, noise, seed);
    const TriangleMesh amls = reconstruct_amls(tube.noisy).mesh, crust = reconstruct_noisy_power_crust(tube.noisy).mesh;
    std::printf("| %.1f | %.2f | %.4f | %.3f | %.3f |\n", wall, noise,
                checks::share_facing(find_outward_normals(tube.noisy).normals, tube.samples.normals),
                checks::examine_mesh(amls).volume / tube.volume, checks::examine_mesh(crust).volume / tube.volume);
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 2)
    {
        std::fprintf(stderr, "amls_sides <seed> [--noise percent,...] [model.ply...]\n");
        return 2;
    }
    const auto seed = unsigned(std::atoi(argv[1]));
    if (argc == 2)
    {
        std::printf("| wall | noise | normals right | AMLS: volume | power crust: volume |\n|---|---|---|---|---|\n");
        for (const double wall : {1.3, 1.6, 2.0})
            for (const double noise : {0.0, 0.05, 0.1, 0.15, 0.2, 0.3})
                print_tube(wall, noise, seed);
        return 0;
    }
    std::vector<std::string> noise = {"0"};
    int first = 2;
    if (argc > 3 && std::strcmp(argv[2], "--noise") == 0)
    {
        noise = split_at_commas(argv[3]);
        first = 4;
    }
    std::printf("| model | noise %% | points | surface: right | angle | filter: right | angle | exact |\n"
                "|---|---|---|---|---|---|---|---|\n");
    for (int k = first; k < argc; ++k)
        for (const std::string& percent : noise)
            try
            {
                print_model(argv[k], std::atof(percent.c_str()), seed);
            }
            catch (const std::exception& problem)
            {
                std::printf("| %s | %s |\n", argv[k], problem.what());
            }
}
