// Topology of the noisy power crust on grids of models x noise, defaults only.
// Usage: crust_grid <folder of models> <seed> [a|c|<model>...] [-s sigma,...] [-o output folder] [-t threads]
//                   [-d on|off] [--raw-mesh | --no-smooth | --no-simplify]
#include "bare_delaunay.h"
#include "mesh_distance.h"
#include "models.h"

#include "filter_noisy_powercrust/reconstruct.h"
#include "tests/checks.h"

#include <recon/geometry.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>

using namespace benchmarks;

int main(int argc, char** argv)
{
    if (argc < 3)
    {
        std::fprintf(stderr,
                     "usage: %s <folder> <seed> [a|c|<model>...] [-s 0,0.1,...] [-o folder] [-t threads] [-d on|off]\n",
                     argv[0]);
        return 2;
    }
    const std::string folder = argv[1];
    const unsigned seed = unsigned(std::atoi(argv[2]));
    std::vector<std::string> models;
    std::vector<double> sigmas = {0, 0.1, 0.2, 0.4};
    std::string output;
    recon::NoisyPowerCrustOptions options;
    options.threads = 1;
    for (int i = 3; i < argc; ++i)
    {
        const std::string word = argv[i];
        if (word == "a" || word == "c")
            models.insert(models.end(), (word == "a" ? grid_a : grid_c).begin(), (word == "a" ? grid_a : grid_c).end());
        else if (word == "-s")
        {
            sigmas.clear();
            for (const std::string& item : split_at_commas(argv[++i]))
                sigmas.push_back(std::atof(item.c_str()));
        }
        else if (word == "-o")
            output = argv[++i];
        else if (word == "-d")
        {
            const std::string how = argv[++i];
            options.denoise = how == "on"    ? recon::Denoise::on
                              : how == "off" ? recon::Denoise::off
                                             : recon::Denoise::automatic;
        }
        else if (word == "--raw-mesh")
            options.smooth = options.simplify = false;
        else if (word == "--no-smooth")
            options.smooth = false;
        else if (word == "--no-simplify")
            options.simplify = false;
        else if (word == "-t")
            options.threads = std::atoi(argv[++i]);
        else
            models.push_back(word);
    }
    if (models.empty())
        models = grid_a;

    int right = 0, cells = 0;
    double log_ratio = 0;
    std::printf("%-22s %5s %5s | %4s %5s %6s %5s | %6s %7s | %5s %s\n", "model", "sigma", "ok", "comp", "genus",
                "volume", "viol", "x DT", "RMS e-6", "balls", "seconds per phase");
    for (const std::string& name : models)
    {
        const Model model = load_model(folder + "/" + name + ".ply");
        const MeshDistance truth(model.mesh);
        for (const double sigma : sigmas)
        {
            const recon::Points cloud = noisy_cloud(model, sigma, seed);
            const double unit = time_bare_delaunay(cloud);
            const double begin = cpu_seconds();
            ++cells;
            try
            {
                const recon::NoisyPowerCrust crust = recon::reconstruct_noisy_power_crust(cloud, options);
                const double ratio = (cpu_seconds() - begin) / unit;
                const checks::MeshReport report = checks::examine_mesh(crust.mesh);
                const double volume = report.volume / model.volume;
                const bool ok = is_right(report, model.genus, volume);
                right += ok;
                log_ratio += std::log(ratio);
                const auto distance = truth.summarise(crust.mesh.vertices);
                std::printf("%-22s %5.2f %5s | %4d %2d/%-2d %6.3f %5.3f | %6.2f %7.0f | %5d", name.c_str(), sigma,
                            ok                                     ? "yes"
                            : report.is_closed_oriented_manifold() ? "-"
                                                                   : "BAD",
                            report.components, report.genus(), model.genus, volume, crust.violated_votes, ratio,
                            1e6 * distance.rms / model.diagonal, crust.balls_kept);
                for (const auto& phase : crust.seconds)
                    std::printf(" %s %.2f", phase.first.c_str(), phase.second);
                std::printf("\n");
                if (!output.empty())
                    save_ply(output + "/" + name + "_" + std::to_string(int(100 * sigma)) + ".ply", crust.mesh);
            }
            catch (const std::exception& e)
            {
                std::printf("%-22s %5.2f  FAIL | %s\n", name.c_str(), sigma, e.what());
            }
            std::fflush(stdout);
        }
    }
    std::printf("%d of %d right, geometric mean %.2f x Delaunay (CPU time)\n", right, cells,
                std::exp(log_ratio / cells));
}
