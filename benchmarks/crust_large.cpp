// One large cloud in one process: crust_large <model.ply> <copies> <sigma %> <seed> [threads]
//   copies >= 0: noisy samples beside each vertex; 0 with sigma 0: the points of the file as they are.
// Prints a Markdown row: topology beside the model's (if it has triangles), time beside CGAL's bare Delaunay, peak
// memory.
#include "bare_delaunay.h"
#include "models.h"

#include "filter_noisy_powercrust/reconstruct.h"
#include "tests/checks.h"
#include "tests/shapes.h"

#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

using namespace benchmarks;

int main(int argc, char** argv)
try
{
    if (argc < 5)
    {
        std::fprintf(stderr, "usage: %s <model.ply> <copies> <sigma %%> <seed> [threads]\n", argv[0]);
        return 2;
    }
    recon::Points points;
    int genus = -1;
    double volume = 0;
    {
        const Model model = load_model(argv[1]);
        if (!model.mesh.triangles.empty())
        {
            genus = model.genus;
            volume = model.volume;
        }
        points = shapes::with_noisy_copies(model.mesh.vertices, std::atof(argv[3]) / 100 * model.diagonal,
                                           std::atoi(argv[2]), std::uint64_t(std::atoi(argv[4])));
    }
    recon::NoisyPowerCrustOptions options;
    options.threads = argc > 5 ? std::atoi(argv[5]) : 1;
    const auto wall = []
    { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); };
    const double begin = cpu_seconds(), start = wall();
    const recon::NoisyPowerCrust crust = recon::reconstruct_noisy_power_crust(points, options);
    const double cpu = cpu_seconds() - begin, waited = wall() - start;
    rusage use;
    getrusage(RUSAGE_SELF, &use);
    const double peak = 1024.0 * double(use.ru_maxrss);
    const checks::MeshReport report = checks::examine_mesh(crust.mesh);
    const double unit = time_bare_delaunay(points);
    std::printf("| %s + %s x %s %% | %zu | %s | %d | %d / %d | %.3f | %.3f | %.1f | %.1f | %.1f | %.2f | %.0f |\n",
                argv[1], argv[2], argv[3], points.size(), report.is_closed_oriented_manifold() ? "yes" : "BAD",
                report.components, report.genus(), genus, volume != 0 ? report.volume / volume : 0,
                crust.violated_votes, cpu, waited, cpu / unit, peak / 1e9, peak / double(points.size()));
    for (const auto& phase : crust.seconds)
        std::fprintf(stderr, "%s %.2f  ", phase.first.c_str(), phase.second);
    std::fprintf(stderr, "\n");
}
catch (const std::exception& e)
{
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
}
