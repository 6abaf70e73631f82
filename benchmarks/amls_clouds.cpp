// Writes the clouds of amls_peers.py: amls_clouds <model folder> <out folder> <seed> grid|even|parts|other [model...]
//   grid: grid B, or the models given, x sigma 0.1, 0.2, 0.4 %. even: of the same models 20,000 noisy samples anywhere
//   on the surface, x sigma 0.3, 0.8 spacings. parts: the same with sigma 0.8 on a tenth and a half, at the lower end
//   of the longest axis, the others exact. other: one point per vertex, thinned, outliers, sharp models.
#include "area_sampler.h"
#include "models.h"

#include "tests/shapes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

using namespace recon;

namespace
{

std::string out_folder, model_folder;

void save(const std::string& name, const std::string& model, const Points& points)
{
    benchmarks::save_ply(out_folder + "/" + name + ".ply", points);
    std::ofstream(out_folder + "/" + name + ".truth") << model_folder << "/" << model << ".ply\n";
}

using shapes::uniform;

int longest_axis(const Points& points)
{
    const Box box = bounding_box(points);
    int axis = 0;
    (box.maximum - box.minimum).maxCoeff(&axis);
    return axis;
}

/// \param share of the samples with noise, the first along the longest axis. \param sigma [spacings].
Points noisy_samples(const benchmarks::Model& model, double sigma, unsigned seed, double share = 1)
{
    constexpr int samples = 20000;
    benchmarks::AreaSampler sampler(model.mesh, seed);
    Points points;
    for (int i = 0; i < samples; ++i)
        points.push_back(sampler.draw());
    Points noisy = shapes::with_noise(points, sigma * std::sqrt(sampler.area() / samples), seed + 1);
    if (share == 1)
        return noisy;
    const int axis = longest_axis(points);
    std::vector<double> along;
    for (const Point& p : points)
        along.push_back(p[axis]);
    const auto limit = along.begin() + std::ptrdiff_t(share * samples);
    std::nth_element(along.begin(), limit, along.end());
    for (int i = 0; i < samples; ++i)
        if (points[i][axis] >= *limit)
            noisy[i] = points[i];
    return noisy;
}

/// Points kept with a probability that falls from 1 to 1/20 along the longest axis.
Points thinned(const Points& points, unsigned seed)
{
    shapes::Random random(seed);
    const Box box = bounding_box(points);
    const int axis = longest_axis(points);
    Points kept;
    for (const Point& p : points)
    {
        const double t = (p[axis] - box.minimum[axis]) / (box.maximum[axis] - box.minimum[axis]);
        if (uniform(random) < std::pow(0.05, t))
            kept.push_back(p);
    }
    return kept;
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 5)
    {
        std::fprintf(stderr, "usage: %s <model folder> <out folder> <seed> grid|even|parts|other [model...]\n",
                     argv[0]);
        return 2;
    }
    model_folder = argv[1];
    out_folder = argv[2];
    const unsigned seed = unsigned(std::stoi(argv[3]));
    const std::string kind = argv[4];
    if (kind == "grid" || kind == "even" || kind == "parts")
    {
        for (const std::string& name : argc > 5 ? std::vector<std::string>(argv + 5, argv + argc) : benchmarks::grid_b)
        {
            const benchmarks::Model model = benchmarks::load_model(model_folder + "/" + name + ".ply");
            if (kind == "grid")
                for (const char* sigma : {"0.1", "0.2", "0.4"})
                    save(name + "_" + sigma, name, benchmarks::noisy_cloud(model, std::stod(sigma), seed));
            else if (kind == "parts")
                for (const char* share : {"0.1", "0.5"})
                    save(name + "_part_" + share, name, noisy_samples(model, 0.8, seed, std::stod(share)));
            else
                for (const char* sigma : {"0.3", "0.8"})
                    save(name + "_even_" + sigma, name, noisy_samples(model, std::stod(sigma), seed));
        }
        return 0;
    }
    for (const std::string name : {"bunny_closed", "armadillo_43k", "rocker_arm"})
    {
        const benchmarks::Model model = benchmarks::load_model(model_folder + "/" + name + ".ply");
        const Points copies = benchmarks::noisy_cloud(model, 0.2, seed);
        save(name + "_one_per_vertex", name, shapes::with_noise(model.mesh.vertices, 0.002 * model.diagonal, seed));
        save(name + "_thinned", name, thinned(copies, seed + 1));
        save(name + "_outliers_1", name, benchmarks::with_outliers(copies, 0.01, seed + 2));
        save(name + "_outliers_5", name, benchmarks::with_outliers(copies, 0.05, seed + 3));
    }
    for (const std::string name : {"fandisk_large", "block", "anchor_dense", "trim_star"})
    {
        const benchmarks::Model model = benchmarks::load_model(model_folder + "/" + name + ".ply");
        save(name + "_sharp", name, benchmarks::noisy_cloud(model, 0.2, seed));
    }
    save("fandisk_noise03", "fandisk", benchmarks::load_model(model_folder + "/fandisk_noise03.ply").mesh.vertices);
    save("block_noise04", "block", benchmarks::load_model(model_folder + "/block_noise04.ply").mesh.vertices);
}
