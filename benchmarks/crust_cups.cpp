// Cups whose walls are about as thick as the noise or the spacing: crust_cups [amls]
// Square and round, as high as wide, open above; one or five noisy samples a spot. One Markdown row a cup: how much of
// its true volume the crust encloses, and its handles, at noise of 0.2 to 0.5 spacings. Filled cups have 2 to 8 of it.
#include "even_samples.h"
#include "models.h"

#include "filter_amls/mesh/reconstruct_amls.h"
#include "filter_noisy_powercrust/reconstruct.h"
#include "tests/checks.h"
#include "tests/shapes.h"

#include <cmath>
#include <cstdio>
#include <exception>
#include <string>

using recon::Points;
using recon::TriangleMesh;

namespace
{

/// A profile turned around z in `sides` steps. \param width of the outside, between flats if there are four.
TriangleMesh make_cup(double width, double wall, int sides)
{
    TriangleMesh mesh;
    constexpr double pi = 3.141592653589793;
    const double stretched = sides == 4 ? std::sqrt(2) : 1;
    const double inner = width / 2 - wall;
    const double profile[4][2] = {{width / 2, 0}, {width / 2, width}, {inner, width}, {inner, wall}};
    for (const auto& [radius, z] : profile)
        for (int k = 0; k < sides; ++k)
        {
            const double angle = 2 * pi * (k + 0.5) / sides;
            mesh.vertices.emplace_back(stretched * radius * std::cos(angle), stretched * radius * std::sin(angle), z);
        }
    const int below = int(mesh.vertices.size()), ground = below + 1;
    mesh.vertices.emplace_back(0, 0, 0);
    mesh.vertices.emplace_back(0, 0, wall);
    for (int k = 0; k < sides; ++k)
    {
        const int next = (k + 1) % sides;
        for (int ring = 0; ring < 3 * sides; ring += sides)
        {
            mesh.triangles.push_back({ring + k, ring + next, ring + sides + next});
            mesh.triangles.push_back({ring + k, ring + sides + next, ring + sides + k});
        }
        mesh.triangles.push_back({next, k, below});
        mesh.triangles.push_back({3 * sides + k, 3 * sides + next, ground});
    }
    return mesh;
}

TriangleMesh reconstruct(const Points& points, bool by_amls)
{
    if (by_amls)
        return recon::reconstruct_amls(points, {}).mesh;
    return recon::reconstruct_noisy_power_crust(points, {}).mesh;
}

} // namespace

int main(int argc, char** argv)
{
    const bool by_amls = argc > 1 && std::string(argv[1]) == "amls";
    if (argc > 2 || (argc == 2 && !by_amls))
    {
        std::fprintf(stderr, "usage: %s [amls]\n", argv[0]);
        return 2;
    }
    constexpr double noises[] = {0.2, 0.3, 0.4, 0.5};
    int hollow[2] = {}, cells = 0;
    std::printf("| cup, width | wall | one a spot 0.2 | 0.3 | 0.4 | 0.5 | five a spot 0.2 | 0.3 | 0.4 | 0.5 |\n"
                "|---|---|---|---|---|---|---|---|---|---|\n");
    for (const int sides : {4, 48})
        for (const double width : {16., 24., 32.})
            for (const double wall : {0.8, 1., 1.2, 1.5})
            {
                const TriangleMesh cup = make_cup(width, wall, sides);
                const double volume = checks::examine_mesh(cup).volume;
                benchmarks::AreaSampler sampler(cup, 5);
                const Points spots =
                    benchmarks::sample_evenly(sampler, benchmarks::draws_per_sample * sampler.area(), 1);
                std::printf("| %s, %g | %g |", sides == 4 ? "square" : "round", width, wall);
                cells += int(std::size(noises));
                for (const int copies : {1, 5})
                    for (const double noise : noises)
                    {
                        const Points points = shapes::noisy_copies(spots, noise, copies, 7);
                        try
                        {
                            const checks::MeshReport report = checks::examine_mesh(reconstruct(points, by_amls));
                            const double share = report.volume / volume;
                            hollow[copies == 5] += share > 0.6 && share < 1.2;
                            std::printf(" %.2f, %d |", share, report.genus());
                        }
                        catch (const std::exception& e)
                        {
                            std::printf(" %s |", e.what());
                        }
                        std::fflush(stdout);
                    }
                std::printf("\n");
            }
    std::printf("\n0.6 to 1.2 of the volume: %d and %d of %d each\n", hollow[0], hollow[1], cells);
}
