// Real scans with normals, thinned and refined back. Usage: pn_scans <folder of models> [share 0.1] [output folder]
// [scan...]
#include "pn_models.h"

#include <recon/search/neighbours.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

using namespace benchmarks;

int main(int argc, char** argv)
{
    if (argc < 2)
        return std::fprintf(stderr, "usage: %s <folder> [share] [output folder] [scan...]\n", argv[0]), 2;
    const double share = argc > 2 ? std::atof(argv[2]) : 0.1;
    std::vector<std::string> scans(argv + std::min(argc, 4), argv + argc);
    if (scans.empty())
        scans = {"uwa_rs1_scan", "hand_points", "building_points"};
    std::printf("%-18s %8s %8s %8s | %28s | %28s | %s\n", "scan", "points", "thinned", "refined",
                "scan to refined: mean, max %", "refined to scan: mean, max %", "scan to thinned: mean %");
    for (const std::string& name : scans)
    {
        const Model model = load_model(std::string(argv[1]) + "/" + name + ".ply");
        recon::OrientedSamples thinned;
        const std::size_t n = model.mesh.vertices.size();
        const auto wanted = std::size_t(share * double(n));
        for (std::size_t k = 0; k < wanted; ++k) // scattered evenly over the file's order
        {
            const std::size_t i = (k * 2654435761u) % n;
            thinned.points.push_back(model.mesh.vertices[i]);
            thinned.normals.push_back(model.normals[i]);
        }
        recon::PnRefineOptions options;
        options.threads = 1;
        const recon::PnRefinement refined = recon::refine_points(thinned, options);
        const recon::OrientedSamples all = join(thinned, refined);
        const double percent = 100 / model.diagonal;
        const auto compare = [&](const recon::Points& from, const recon::Points& to)
        {
            const recon::NeighbourSearch search(to);
            double sum = 0, most = 0;
            for (const recon::Point& p : from)
            {
                const double d = (to[std::size_t(search.nearest(p))] - p).norm();
                sum += d;
                most = std::max(most, d);
            }
            return std::array<double, 2>{sum / double(from.size()) * percent, most * percent};
        };
        const auto there = compare(model.mesh.vertices, all.points),
                   back = compare(refined.points, model.mesh.vertices),
                   thin = compare(model.mesh.vertices, thinned.points);
        std::printf("%-18s %8zu %8zu %8zu | %16.4f %11.3f | %16.4f %11.3f | %12.4f\n", name.c_str(), n,
                    thinned.points.size(), all.points.size(), there[0], there[1], back[0], back[1], thin[0]);
        for (const std::string& warning : refined.warnings)
            std::printf("   %s\n", warning.c_str());
        if (argc > 3)
            save_ply(std::string(argv[3]) + "/" + name + "_refined.ply", all.points, all.normals);
    }
}
