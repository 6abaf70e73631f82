// Time and memory of filter 3 (surface and projection) by number of points: amls_speed [threads] [cloud.ply...]
// Without clouds: tori of 100,000 to 2 million points with noise of half the spacing, one process each for the memory.
#include "models.h"

#include "filter_amls/surface/project.h"

#include "tests/shapes.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace recon;

namespace
{

void measure(const std::string& name, const Points& points, int threads)
{
    rusage before{}, after{};
    getrusage(RUSAGE_SELF, &before);
    const auto start = std::chrono::steady_clock::now();
    const double begin = benchmarks::cpu_seconds();
    AmlsOptions options;
    options.threads = threads;
    const AmlsSurface surface = build_amls_surface(points, options);
    AmlsProjectionOptions projection;
    projection.threads = threads;
    const AmlsProjection result = project_to_amls(points, surface, projection);
    const double cpu = benchmarks::cpu_seconds() - begin;
    const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    getrusage(RUSAGE_SELF, &after);
    std::printf("| %s | %zu | %d | %.2f | %.2f | %.1f | %.2f | %.2f |\n", name.c_str(), points.size(), threads, cpu,
                wall, 1e6 * cpu / double(points.size()), after.ru_maxrss / 1048576.0, before.ru_maxrss / 1048576.0);
}

} // namespace

int main(int argc, char** argv)
{
    const int threads = argc > 1 ? std::atoi(argv[1]) : 1;
    std::printf("| cloud | points | threads | CPU s | wall s | us per point | peak GB | before GB |\n"
                "|---|---|---|---|---|---|---|---|\n");
    std::fflush(stdout);
    const auto apart = [](const auto& run)
    {
        if (fork() == 0)
        {
            run();
            std::fflush(stdout);
            std::_Exit(0);
        }
        wait(nullptr);
    };
    for (int i = 2; i < argc; ++i)
        apart(
            [&]
            {
                const std::string path = argv[i];
                measure(path.substr(path.find_last_of('/') + 1), benchmarks::load_model(path).mesh.vertices, threads);
            });
    if (argc > 2)
        return 0;
    for (const int n : {100000, 200000, 500000, 1000000, 2000000})
        apart(
            [&]
            {
                const double spacing = std::sqrt(4 * M_PI * M_PI * 0.4 / n);
                measure("torus", shapes::with_noise(shapes::torus(n, 1, 0.4, 61).points, 0.5 * spacing, 62), threads);
            });
}
