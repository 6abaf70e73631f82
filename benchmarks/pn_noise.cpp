// Refinement of samples with bad normals and positions, against the mesh they were taken from. Usage: pn_noise <folder
// of models> [model...]
#include "mesh_distance.h"
#include "pn_models.h"

#include "tests/shapes.h"

#include <Eigen/Geometry>

#include <cmath>
#include <cstdio>
#include <random>

using namespace benchmarks;
using recon::Vector;

namespace
{

struct Harm
{
    const char* name;
    double degrees = 0;  ///< Of noise on the normals.
    double position = 0; ///< Standard deviation [diagonals].
    double turned = 0;   ///< Share of normals that point inward.
};

int harm(const Harm& h, double diagonal, recon::OrientedSamples& samples)
{
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform;
    const auto noise = [&] { return shapes::draw_vector([&] { return normal(random); }); };
    int turned = 0;
    for (std::size_t i = 0; i < samples.points.size(); ++i)
    {
        Vector& n = samples.normals[i];
        const Vector aside = noise();
        n = (n + std::tan(h.degrees * M_PI / 180) * (aside - aside.dot(n) * n)).normalized();
        samples.points[i] += h.position * diagonal * noise();
        if (uniform(random) < h.turned)
        {
            n = -n;
            ++turned;
        }
    }
    return turned;
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 2)
        return std::fprintf(stderr, "usage: %s <folder> [model...]\n", argv[0]), 2;
    std::vector<std::string> models(argv + 2, argv + argc);
    if (models.empty())
        models = {"igea", "rocker_arm"};
    for (const std::string& name : models)
    {
        const Model model = load_model(std::string(argv[1]) + "/" + name + ".ply");
        const MeshDistance distance(model.mesh);
        const double percent = 100 / model.diagonal;
        for (const Harm& h :
             {Harm{"none"}, Harm{"normals 15 degrees", 15}, Harm{"normals 30 degrees", 30},
              Harm{"positions 0.1 %", 0, 0.001}, Harm{"2 % turned", 0, 0, 0.02}, Harm{"all three", 15, 0.001, 0.02}})
        {
            recon::OrientedSamples samples = sample_mesh(model.mesh, 3500, 1);
            const int turned = harm(h, model.diagonal, samples);
            recon::PnRefineOptions options;
            options.threads = 1;
            const recon::PnRefinement refined = recon::refine_points(samples, options);
            const auto summary = distance.summarise(refined.points);
            std::printf("%-12s %-20s %7zu points | RMS %.4f max %.3f %% | turned %d, found %zu\n", name.c_str(), h.name,
                        samples.points.size() + refined.points.size(), summary.rms * percent, summary.largest * percent,
                        turned, refined.turned_normals.size());
        }
    }
}
