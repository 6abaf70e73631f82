// Clouds that are not each vertex plus four copies: crust_harsh <folder of models> <seed> [model...]
// One Markdown row a cell: one noisy sample per vertex, thinned along the longest axis, outliers, two misregistered
// scans.
#include "bare_delaunay.h"
#include "models.h"

#include "filter_noisy_powercrust/reconstruct.h"
#include "tests/checks.h"
#include "tests/shapes.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>

using namespace benchmarks;
using recon::Point;
using recon::Points;

namespace
{

using shapes::uniform;

/// Points kept with a probability that falls from 1 to 1/factor along the longest axis.
Points thinned(const Points& points, double factor, unsigned seed)
{
    shapes::Random random(seed);
    const recon::Box box = recon::bounding_box(points);
    int axis = 0;
    (box.maximum - box.minimum).maxCoeff(&axis);
    Points kept;
    for (const Point& p : points)
    {
        const double t = (p[axis] - box.minimum[axis]) / (box.maximum[axis] - box.minimum[axis]);
        if (uniform(random) < std::pow(factor, -t))
            kept.push_back(p);
    }
    return kept;
}

/// Two scans of noise sigma with two samples per vertex each, the second moved by two sigma along the diagonal of the
/// axes.
Points misregistered(const Points& vertices, double sigma, unsigned seed)
{
    Points points;
    for (int scan = 0; scan < 2; ++scan)
        for (int copy = 0; copy < 2; ++copy)
            for (const Point& p : shapes::with_noise(vertices, sigma, seed + unsigned(2 * scan + copy)))
                points.push_back(p + Point::Constant(scan * 2 * sigma / std::sqrt(3.0)));
    return points;
}

struct Cloud
{
    const char* name;
    std::function<Points(const Model&, unsigned seed)> make;
};

/// Cells of the grids with a share of outliers. \param salt makes each row's outliers its own.
std::function<Points(const Model&, unsigned seed)> beside_outliers(double percent, double share, unsigned salt)
{
    return [=](const Model& m, unsigned seed)
    { return with_outliers(noisy_cloud(m, percent, seed), share, seed + salt); };
}

const std::vector<Cloud> clouds = {
    {"one per vertex, 0.1 %",
     [](const Model& m, unsigned seed) { return shapes::with_noise(m.mesh.vertices, 0.001 * m.diagonal, seed); }},
    {"one per vertex, 0.2 %",
     [](const Model& m, unsigned seed) { return shapes::with_noise(m.mesh.vertices, 0.002 * m.diagonal, seed); }},
    {"0.2 %, thinned 5 x",
     [](const Model& m, unsigned seed) { return thinned(noisy_cloud(m, 0.2, seed), 5, seed + 1); }},
    {"0.2 %, thinned 20 x",
     [](const Model& m, unsigned seed) { return thinned(noisy_cloud(m, 0.2, seed), 20, seed + 1); }},
    {"0.2 %, 1 % outliers", beside_outliers(0.2, 0.01, 2)},
    {"0.2 %, 5 % outliers", beside_outliers(0.2, 0.05, 3)},
    {"0.2 %, 30 % outliers", beside_outliers(0.2, 0.3, 7)},
    {"0.2 %, as many outliers as points", beside_outliers(0.2, 1, 8)},
    {"two scans at 0.2 %, 2 sigma apart",
     [](const Model& m, unsigned seed) { return misregistered(m.mesh.vertices, 0.002 * m.diagonal, seed); }},
    {"no noise, 1 % outliers", beside_outliers(0, 0.01, 4)},
    {"no noise, 5 % outliers", beside_outliers(0, 0.05, 5)},
    {"no noise, 30 % outliers", beside_outliers(0, 0.3, 9)},
    {"no noise, as many outliers as points", beside_outliers(0, 1, 10)},
    {"0.05 %, 5 % outliers", beside_outliers(0.05, 0.05, 6)},
};

} // namespace

int main(int argc, char** argv)
{
    if (argc < 3)
    {
        std::fprintf(stderr, "usage: %s <folder of models> <seed> [model...]\n", argv[0]);
        return 2;
    }
    const unsigned seed = unsigned(std::atoi(argv[2]));
    std::vector<std::string> models(argv + 3, argv + argc);
    if (models.empty())
        models = {"bunny_closed", "armadillo_43k", "horse", "rocker_arm", "elephant_refined", "fertility"};
    recon::NoisyPowerCrustOptions options;
    options.threads = 1;
    int right = 0, cells = 0;
    std::printf("| cloud | model | points | ok | components | genus / true | volume | violated votes | outliers left "
                "out | x DT |\n"
                "|---|---|---|---|---|---|---|---|---|---|\n");
    for (const Cloud& cloud : clouds)
        for (const std::string& name : models)
        {
            ++cells;
            const Model model = load_model(argv[1] + ("/" + name) + ".ply");
            const Points points = cloud.make(model, seed);
            try
            {
                const double unit = time_bare_delaunay(points), begin = cpu_seconds();
                const recon::NoisyPowerCrust crust = recon::reconstruct_noisy_power_crust(points, options);
                const double ratio = (cpu_seconds() - begin) / unit;
                const checks::MeshReport report = checks::examine_mesh(crust.mesh);
                const double volume = report.volume / model.volume;
                const bool ok = is_right(report, model.genus, volume);
                right += ok;
                std::printf("| %s | %s | %zu | %s | %d | %d / %d | %.3f | %.3f | %d | %.1f |\n", cloud.name,
                            name.c_str(), points.size(),
                            ok                                     ? "yes"
                            : report.is_closed_oriented_manifold() ? "-"
                                                                   : "BAD",
                            report.components, report.genus(), model.genus, volume, crust.violated_votes,
                            crust.outliers, ratio);
            }
            catch (const std::exception& e)
            {
                std::printf("| %s | %s | %zu | failed: %s |\n", cloud.name, name.c_str(), points.size(), e.what());
            }
            std::fflush(stdout);
        }
    std::printf("\n%d of %d right\n", right, cells);
}
