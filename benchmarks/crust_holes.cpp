// Holes of a scan left open: crust_holes <folder of models> <seed> [model...]
// From models six patches are cut, or none; one Markdown row a model, a column per noise and radius of the patches in
// spacings: rims of the crust with `open_holes`, and how far its farthest vertex lies from the cut model in spacings.
#include "mesh_distance.h"
#include "models.h"
#include "pn_models.h"

#include "filter_noisy_powercrust/reconstruct.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

using namespace benchmarks;
using recon::Point;
using recon::Points;

namespace
{

constexpr int patches = 6;

/// The model without balls of this radius around six vertices, which lie apart.
Model cut(const Model& model, double radius, unsigned seed)
{
    std::mt19937 random(seed);
    Points centres;
    for (int attempt = 0; int(centres.size()) < patches && radius > 0 && attempt < 10000; ++attempt)
    {
        const Point& p = model.mesh.vertices[random() % model.mesh.vertices.size()];
        if (std::all_of(centres.begin(), centres.end(), [&](const Point& c) { return (c - p).norm() > 3 * radius; }))
            centres.push_back(p);
    }
    const auto is_cut = [&](const Point& p)
    { return std::any_of(centres.begin(), centres.end(), [&](const Point& c) { return (c - p).norm() < radius; }); };
    Model result = model;
    result.mesh.vertices.clear();
    std::vector<int> number;
    for (const Point& p : model.mesh.vertices)
    {
        number.push_back(is_cut(p) ? -1 : int(result.mesh.vertices.size()));
        if (number.back() >= 0)
            result.mesh.vertices.push_back(p);
    }
    result.mesh.triangles.clear();
    for (const auto& t : model.mesh.triangles)
        if (number[t[0]] >= 0 && number[t[1]] >= 0 && number[t[2]] >= 0)
            result.mesh.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
    return result;
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 3)
    {
        std::fprintf(stderr, "usage: crust_holes <folder of models> <seed> [model...]\n");
        return 2;
    }
    const std::string folder = argv[1];
    const unsigned seed = unsigned(std::atoi(argv[2]));
    std::vector<std::string> names(argv + 3, argv + argc);
    if (names.empty())
        names = grid_a;
    const std::vector<double> sigmas = {0, 0.2}, radii = {0, 4, 6, 10};
    std::printf("| model |");
    for (const double sigma : sigmas)
        for (const double radius : radii)
            std::printf(" %g %%, %g |", sigma, radius);
    std::printf("\n|---|");
    for (std::size_t i = 0; i < sigmas.size() * radii.size(); ++i)
        std::printf("---|");
    std::printf("\n");
    for (const std::string& name : names)
    {
        const Model model = load_model(folder + "/" + name + ".ply");
        const double spacing = std::sqrt(surface_area(model.mesh) / double(model.mesh.vertices.size()));
        std::printf("| %s |", name.c_str());
        for (const double sigma : sigmas)
            for (const double radius : radii)
            {
                const Model open = cut(model, radius * spacing, seed);
                recon::NoisyPowerCrustOptions options;
                options.open_holes = true;
                const auto crust = recon::reconstruct_noisy_power_crust(noisy_cloud(open, sigma, seed + 1), options);
                const MeshDistance truth(open.mesh);
                std::printf(" %d, %.1f |", crust.boundary_loops,
                            truth.summarise(crust.mesh.vertices).largest / spacing);
                std::fflush(stdout);
            }
        std::printf("\n");
    }
}
