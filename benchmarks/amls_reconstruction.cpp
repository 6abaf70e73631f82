// "Surface Reconstruction: AMLS" on grid A, defaults only, beside the raw power crust (no denoising, nothing moved) of
// the same cloud. amls_reconstruction <folder of models> <seed> [model...] [--sigmas 0,0.1,...] [--no-raw]
#include "mesh_distance.h"
#include "models.h"

#include "filter_amls/mesh/reconstruct_amls.h"
#include "filter_noisy_powercrust/reconstruct.h"

#include "tests/checks.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>

using namespace benchmarks;

namespace
{

struct Judged
{
    checks::MeshReport mesh;
    double volume = 0, rms = 0;
    bool right = false;
};

Judged judge(const recon::TriangleMesh& mesh, const Model& model, const MeshDistance& truth)
{
    Judged judged;
    judged.mesh = checks::examine_mesh(mesh);
    judged.volume = judged.mesh.volume / model.volume;
    judged.rms = 1e6 * truth.summarise(mesh.vertices).rms / model.diagonal;
    judged.right = judged.mesh.is_closed_oriented_manifold() && judged.mesh.components == 1 &&
                   judged.mesh.genus() == model.genus && std::abs(judged.volume - 1) < 0.02;
    return judged;
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 3)
    {
        std::fprintf(stderr, "usage: %s <folder of models> <seed> [model...] [--sigmas 0,0.1,...] [--no-raw]\n",
                     argv[0]);
        return 2;
    }
    const std::string folder = argv[1];
    const unsigned seed = unsigned(std::atoi(argv[2]));
    std::vector<std::string> models, sigmas = {"0", "0.1", "0.2", "0.4"};
    bool with_raw = true;
    for (int i = 3; i < argc; ++i)
    {
        const std::string word = argv[i];
        if (word == "--no-raw")
            with_raw = false;
        else if (word == "--sigmas" && i + 1 < argc)
            sigmas = split_at_commas(argv[++i]);
        else
            models.push_back(word);
    }
    if (models.empty())
        models = grid_a;

    std::printf(
        "| model | sigma %% | right | components | genus | volume | RMS 1e-6 | CPU s | raw crust: right | RMS | "
        "AMLS / raw |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
    int right = 0, cells = 0;
    for (const std::string& name : models)
    {
        const Model model = load_model(folder + "/" + name + ".ply");
        const MeshDistance truth(model.mesh);
        for (const std::string& sigma : sigmas)
        {
            const recon::Points cloud = noisy_cloud(model, std::atof(sigma.c_str()), seed);
            ++cells;
            try
            {
                recon::AmlsReconstructionOptions options;
                options.threads = 1;
                const double begin = cpu_seconds();
                const recon::AmlsReconstruction result = recon::reconstruct_amls(cloud, options);
                const double seconds = cpu_seconds() - begin;
                const Judged amls = judge(result.mesh, model, truth);
                right += amls.right;
                std::printf("| %s | %s | %s | %d | %d / %d | %.3f | %.0f | %.1f |", name.c_str(), sigma.c_str(),
                            amls.right                                ? "yes"
                            : amls.mesh.is_closed_oriented_manifold() ? "no"
                                                                      : "BAD",
                            amls.mesh.components, amls.mesh.genus(), model.genus, amls.volume, amls.rms, seconds);
                if (with_raw)
                {
                    recon::NoisyPowerCrustOptions raw_options;
                    raw_options.threads = 1;
                    raw_options.denoise = recon::Denoise::off;
                    raw_options.smooth = raw_options.simplify = false;
                    const Judged raw =
                        judge(recon::reconstruct_noisy_power_crust(cloud, raw_options).mesh, model, truth);
                    std::printf(" %s | %.0f | %.2f |", raw.right ? "yes" : "no", raw.rms, amls.rms / raw.rms);
                }
                std::printf("\n");
            }
            catch (const std::exception& e)
            {
                std::printf("| %s | %s | failed: %s |\n", name.c_str(), sigma.c_str(), e.what());
            }
            std::fflush(stdout);
        }
    }
    std::printf("\n%d of %d right\n", right, cells);
}
