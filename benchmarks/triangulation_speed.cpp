// Wall-clock time of the Delaunay triangulation as flat arrays with circumcentres, beside CGAL's bare one of the same
// points. Usage: triangulation_speed <repetitions> <model.ply>... Prints medians for 1 and 2 threads, noise-free and
// with four copies at 0.2 %.
#include "bare_delaunay.h"
#include "median_seconds.h"
#include "models.h"

#include <recon/triangulation/delaunay.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>

int main(int argc, char** argv)
{
    if (argc < 3)
    {
        std::fprintf(stderr, "usage: %s <repetitions> <model.ply>...\n", argv[0]);
        return 2;
    }
    const int repetitions = std::atoi(argv[1]);
    std::printf("| model | sigma %% | points | CGAL s | 1 thread | 2 threads |\n|---|---|---|---|---|---|\n");
    for (int i = 2; i < argc; ++i)
    {
        const benchmarks::Model model = benchmarks::load_model(argv[i]);
        for (const double sigma : {0.0, 0.2})
        {
            const recon::Points cloud = benchmarks::noisy_cloud(model, sigma, 21);
            const double bare = benchmarks::median_seconds(repetitions, [&] { benchmarks::time_bare_delaunay(cloud); });
            std::printf("| %s | %.1f | %zu | %.2f |", std::filesystem::path(argv[i]).stem().c_str(), sigma,
                        cloud.size(), bare);
            for (const int threads : {1, 2})
            {
                const double own =
                    benchmarks::median_seconds(repetitions, [&] { recon::triangulate_delaunay(cloud, {}, threads); });
                std::printf(" %.2f |", own / bare);
            }
            std::printf("\n");
            std::fflush(stdout);
        }
    }
}
