// Clouds of even samples on the triangles of models, whatever their vertices:
// crust_even <samples> <seed> <model.ply>...
// One Markdown row a cell: without noise, one noisy sample a spot, five noisy samples a spot. Noise in spacings.
#include "even_samples.h"
#include "mesh_distance.h"
#include "models.h"

#include "filter_noisy_powercrust/reconstruct.h"
#include "tests/checks.h"
#include "tests/shapes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>

using namespace benchmarks;
using recon::Points;

namespace
{

struct Cloud
{
    double noise; ///< [spacings]
    int samples_a_spot;
};

} // namespace

int main(int argc, char** argv)
{
    if (argc < 4)
    {
        std::fprintf(stderr, "usage: %s <samples> <seed> <model.ply>...\n", argv[0]);
        return 2;
    }
    const int samples = std::atoi(argv[1]);
    const unsigned seed = unsigned(std::atoi(argv[2]));
    recon::NoisyPowerCrustOptions options;
    options.threads = 1;
    int right = 0, cells = 0;
    std::printf("| model | noise [spacings] | samples a spot | ok | components | genus / true | volume | RMS "
                "[spacings] | denoised | violated votes |\n"
                "|---|---|---|---|---|---|---|---|---|---|\n");
    for (int k = 3; k < argc; ++k)
    {
        const Model model = load_model(argv[k]);
        const std::string name = std::filesystem::path(argv[k]).stem().string();
        const MeshDistance truth(model.mesh);
        AreaSampler sampler(model.mesh, seed);
        const double spacing = std::sqrt(sampler.area() / samples);
        const Points spots = sample_evenly(sampler, draws_per_sample * samples, spacing);
        for (const Cloud& cloud :
             {Cloud{0, 1}, Cloud{0.1, 1}, Cloud{0.2, 1}, Cloud{0.3, 1}, Cloud{0.5, 1}, Cloud{0.3, 5}})
        {
            const Points points = shapes::noisy_copies(spots, cloud.noise * spacing, cloud.samples_a_spot, seed);
            ++cells;
            std::printf("| %s | %g | %d | ", name.c_str(), cloud.noise, cloud.samples_a_spot);
            try
            {
                const recon::NoisyPowerCrust crust = recon::reconstruct_noisy_power_crust(points, options);
                const checks::MeshReport report = checks::examine_mesh(crust.mesh);
                const double volume = report.volume / model.volume;
                const bool ok = is_right(report, model.genus, volume);
                right += ok;
                std::printf("%s | %d | %d / %d | %.3f | %.3f | %s | %.3f |\n", ok ? "yes" : "-", report.components,
                            report.genus(), model.genus, volume, truth.summarise(crust.mesh.vertices).rms / spacing,
                            crust.denoised ? "yes" : "no", crust.violated_votes);
            }
            catch (const std::exception& e)
            {
                std::printf("- | %s\n", e.what());
            }
            std::fflush(stdout);
        }
    }
    std::printf("\n%d of %d right\n", right, cells);
}
