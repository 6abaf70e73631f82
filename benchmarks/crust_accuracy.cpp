// How near the surface comes to the true one between its vertices, both ways: the raw crust, the simplified one, the
// default (through the samples, edges along creases), and CGAL's advancing front, which interpolates too. Usage:
// crust_accuracy <folder of models> <seed> [model...] [--sigmas 0,0.2] [--samples n]
// Samples are the vertices (and noisy copies of them), or n points all over the surface, so that its own triangles are
// no answer.
#include "mesh_distance.h"
#include "models.h"
#include "pn_models.h"

#include "filter_noisy_powercrust/reconstruct.h"

#include "tests/checks.h"

#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <string>
#include <utility>

using namespace benchmarks;
using recon::Points;
using recon::TriangleMesh;

namespace
{

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
constexpr int surface_points = 100'000;

std::vector<Kernel::Point_3> to_cgal(const Points& points)
{
    std::vector<Kernel::Point_3> result;
    for (const auto& p : points)
        result.emplace_back(p.x(), p.y(), p.z());
    return result;
}

TriangleMesh advance_front(const Points& points)
{
    const auto copy = to_cgal(points);
    std::vector<std::array<std::size_t, 3>> found;
    CGAL::advancing_front_surface_reconstruction(copy.begin(), copy.end(), std::back_inserter(found));
    TriangleMesh mesh;
    mesh.vertices = points;
    for (const auto& t : found)
        mesh.triangles.push_back({int(t[0]), int(t[1]), int(t[2])});
    return mesh;
}

/// Of a manifold.
std::size_t count_intersections(const TriangleMesh& mesh)
{
    using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
    Mesh copy;
    for (const auto& p : to_cgal(mesh.vertices))
        copy.add_vertex(p);
    for (const auto& t : mesh.triangles)
        copy.add_face(Mesh::Vertex_index(unsigned(t[0])), Mesh::Vertex_index(unsigned(t[1])),
                      Mesh::Vertex_index(unsigned(t[2])));
    std::vector<std::pair<Mesh::Face_index, Mesh::Face_index>> pairs;
    CGAL::Polygon_mesh_processing::self_intersections(copy, std::back_inserter(pairs));
    return pairs.size();
}

void report(const char* how, const TriangleMesh& mesh, const Model& model, const MeshDistance& truth,
            const Points& true_points)
{
    const auto found = checks::examine_mesh(mesh);
    const bool right = found.is_closed_oriented_manifold() && found.components == 1 && found.genus() == model.genus;
    const double unit = 1e6 / model.diagonal;
    const auto there = truth.summarise(sample_mesh(mesh, surface_points, 1).points),
               back = MeshDistance(mesh).summarise(true_points);
    std::printf(" %s | %s | %zu | %.0f | %.0f | %.0f | %.0f | %.0f | %s |\n", how, right ? "yes" : "-",
                mesh.vertices.size(), unit * truth.summarise(mesh.vertices).rms, unit * there.rms, unit * there.largest,
                unit * back.rms, unit * back.largest,
                found.is_closed_oriented_manifold() ? std::to_string(count_intersections(mesh)).c_str() : "");
    std::fflush(stdout);
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 3)
    {
        std::fprintf(stderr, "usage: %s <folder of models> <seed> [model...] [--sigmas 0,0.2] [--samples n]\n",
                     argv[0]);
        return 2;
    }
    const unsigned seed = unsigned(std::atoi(argv[2]));
    int samples = 0;
    std::vector<std::string> models, sigmas = {"0"};
    for (int i = 3; i < argc; ++i)
        if (argv[i] == std::string("--sigmas") && i + 1 < argc)
            sigmas = split_at_commas(argv[++i]);
        else if (argv[i] == std::string("--samples") && i + 1 < argc)
            samples = std::atoi(argv[++i]);
        else
            models.push_back(argv[i]);
    std::printf("| model | sigma %% | surface | right | vertices | vertices' RMS | to the true surface, RMS | largest "
                "| back, RMS | largest "
                "| intersections |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (const std::string& name : models.empty() ? grid_a : models)
    {
        const Model model = load_model(std::string(argv[1]) + "/" + name + ".ply");
        const MeshDistance truth(model.mesh);
        const Points true_points = sample_mesh(model.mesh, surface_points, 2).points;
        for (const std::string& sigma : sigmas)
        {
            Model sampled = model;
            if (samples > 0)
                sampled.mesh = {sample_mesh(model.mesh, samples, seed).points, {}, {}};
            const Points cloud = noisy_cloud(sampled, std::atof(sigma.c_str()), seed);
            recon::NoisyPowerCrustOptions options;
            const auto crust = [&] { return recon::reconstruct_noisy_power_crust(cloud, options).mesh; };
            const auto begin_row = [&] { std::printf("| %s | %s |", name.c_str(), sigma.c_str()); };
            options.smooth = options.simplify = false;
            begin_row();
            report("raw crust", crust(), model, truth, true_points);
            options.simplify = true;
            if (std::atof(sigma.c_str()) > 0) // without noise this is the default
            {
                begin_row();
                report("simplified", crust(), model, truth, true_points);
            }
            options.smooth = true;
            begin_row();
            report("default", crust(), model, truth, true_points);
            if (std::atof(sigma.c_str()) == 0)
            {
                begin_row();
                report("advancing front", advance_front(cloud), model, truth, true_points);
            }
        }
    }
}
