// Speed of PN refinement, beside CGAL's edge-aware upsampling in the same run. Points per second of CPU time on one
// thread and of wall time on several. Usage: pn_speed <model.ply> [input samples] [output points] [also 10 M points:
// -x]
#include "pn_models.h"

#include <recon/progress.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sys/resource.h>

using namespace benchmarks;

namespace
{

struct Run
{
    std::size_t made = 0;
    double cpu = 0, wall = 0;
    std::vector<std::pair<std::string, double>> phases;
    recon::PnRefinement refined;
};

Run run(const recon::OrientedSamples& input, const recon::PnRefineOptions& options)
{
    Run r;
    const double cpu = cpu_seconds();
    const auto start = std::chrono::steady_clock::now();
    r.refined = recon::refine_points(input, options);
    r.wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    r.cpu = cpu_seconds() - cpu;
    r.made = r.refined.points.size();
    r.phases = r.refined.seconds;
    return r;
}

void print(const char* name, const Run& r)
{
    std::printf("%-34s %9zu %7.2f %7.2f %8.3f %8.3f  ", name, r.made, r.cpu, r.wall, double(r.made) / r.cpu / 1e6,
                double(r.made) / r.wall / 1e6);
    for (const auto& [phase, seconds] : r.phases)
        std::printf(" %s %.2f", phase.c_str(), seconds);
    std::printf("\n");
    std::fflush(stdout);
}

bool same(const recon::PnRefinement& a, const recon::PnRefinement& b)
{
    return a.points.size() == b.points.size() &&
           std::memcmp(a.points.data(), b.points.data(), a.points.size() * sizeof(recon::Point)) == 0 &&
           std::memcmp(a.normals.data(), b.normals.data(), a.normals.size() * sizeof(recon::Vector)) == 0;
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 2)
        return std::fprintf(stderr, "usage: %s <model.ply> [input samples] [output points] [-x]\n", argv[0]), 2;
    const int samples = argc > 2 ? std::atoi(argv[2]) : 20000;
    const int wanted = argc > 3 ? std::atoi(argv[3]) : 1000000;
    const recon::OrientedSamples input = sample_mesh(load_model(argv[1]).mesh, samples, 1);
    std::printf("%-34s %9s %7s %7s %8s %8s\n", "", "new", "CPU s", "wall s", "M/CPU s", "M/wall s");

    recon::PnRefineOptions options;
    options.threads = 1;
    options.steps = 0;
    for (double n = samples; n < wanted && options.steps < 12; ++options.steps)
        n *= options.steps < 2 ? 1.9 : 2.5;
    const struct
    {
        const char* name;
        bool fast;
        recon::PnNeighbourhood neighbourhood;
    } modes[] = {{"fast, 1 thread", true, recon::PnNeighbourhood::automatic},
                 {"automatic, 1 thread", false, recon::PnNeighbourhood::automatic},
                 {"accurate, 1 thread", false, recon::PnNeighbourhood::accurate}};
    Run one;
    double fast_rate = 0;
    for (const auto& mode : modes)
    {
        options.fast = mode.fast;
        options.neighbourhood = mode.neighbourhood;
        const Run r = run(input, options);
        print(mode.name, r);
        if (mode.fast)
            fast_rate = double(r.made) / r.cpu;
    }
    options.neighbourhood = recon::PnNeighbourhood::automatic;
    options.fast = true;
    options.threads = 1;
    one = run(input, options);
    for (int threads : {2, 3})
    {
        options.threads = threads;
        const Run r = run(input, options);
        print(threads == 2 ? "fast, 2 threads" : "fast, 3 threads", r);
        std::printf("  the same bits as with 1 thread: %s\n", same(one.refined, r.refined) ? "yes" : "NO");
    }
    const int cgal_count = 4 * samples;
    const EdgeAwareUpsampling cgal = upsample_edge_aware(input, cgal_count);
    const double cgal_rate = double(cgal.appended.points.size()) / cgal.cpu_seconds;
    std::printf("%-34s %9zu %7.2f %7s %8.3f\n", "CGAL edge-aware upsampling", cgal.appended.points.size(),
                cgal.cpu_seconds, "", cgal_rate / 1e6);
    std::printf("fast / CGAL per new point and CPU second: %.1f\n", fast_rate / cgal_rate);

    if (argc > 4)
    {
        one = {};
        options.threads = 0;
        options.steps += 3;
        options.max_points = 12000000;
        const Run r = run(input, options);
        print("as many steps as 12 M points allow", r);
        rusage usage{};
        getrusage(RUSAGE_SELF, &usage);
        std::printf("largest memory: %.2f GB\n", double(usage.ru_maxrss) / 1e6);
    }
}
