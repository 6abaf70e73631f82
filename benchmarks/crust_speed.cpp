// Wall-clock time of the noisy power crust beside CGAL's bare Delaunay triangulation of the same points, in one
// process. Prints for 1 and 2 threads the ratio of the medians, for the whole filter, without smoothing, and for the
// paper's path alone (no denoising, smoothing or simplification), noise-free and with four copies at 0.2 %.
//
// Usage: crust_speed <model.ply> [repetitions]
#include "bare_delaunay.h"
#include "median_seconds.h"
#include "models.h"

#include "filter_noisy_powercrust/reconstruct.h"

#include <cstdio>
#include <cstdlib>
#include <utility>

int main(int argc, char** argv)
{
    if (argc < 2)
    {
        std::fprintf(stderr, "usage: %s <model.ply> [repetitions]\n", argv[0]);
        return 2;
    }
    const benchmarks::Model model = benchmarks::load_model(argv[1]);
    const int repetitions = argc > 2 ? std::atoi(argv[2]) : 3;
    std::printf(
        "| sigma %% | points | path | threads | bare Delaunay s | filter s | ratio |\n|---|---|---|---|---|---|---|\n");
    for (const double sigma : {0.0, 0.2})
    {
        const recon::Points cloud = benchmarks::noisy_cloud(model, sigma, 21);
        const double bare = benchmarks::median_seconds(repetitions, [&] { benchmarks::time_bare_delaunay(cloud); });
        enum class Path
        {
            whole,
            no_smoothing,
            paper
        };
        for (const auto& [path, name] :
             {std::pair(Path::whole, "default"), std::pair(Path::no_smoothing, "no smoothing"),
              std::pair(Path::paper, "paper's")})
            for (const int threads : {1, 2})
            {
                recon::NoisyPowerCrustOptions options;
                options.threads = threads;
                options.smooth = path == Path::whole;
                if (path == Path::paper)
                {
                    options.denoise = recon::Denoise::off;
                    options.simplify = false;
                }
                const double whole = benchmarks::median_seconds(
                    repetitions, [&] { recon::reconstruct_noisy_power_crust(cloud, options); });
                std::printf("| %.1f | %zu | %s | %d | %.2f | %.2f | %.1f |\n", sigma, cloud.size(), name, threads, bare,
                            whole, whole / bare);
            }
    }
}
