// The noise estimate over the true standard deviation. amls_noise <model folder>: grid B, shapes and thin plates.
#include "models.h"

#include "tests/shapes.h"

#include "filter_amls/surface/project.h"

#include <recon/noise/noise.h>

#include <cmath>
#include <cstdio>

using namespace recon;

namespace
{

constexpr unsigned seed = 31;

double estimate(const Points& points)
{
    NoiseOptions options;
    options.threads = 1;
    return estimate_noise(points, options).median_sigma();
}

/// Prints a row: for each noise the ratio with five samples a spot and with one, in brackets the noise in spacings.
void print_row(const char* name, const Points& exact, double diagonal, bool keep_exact)
{
    std::printf("| %s |", name);
    for (const double percent : {0.05, 0.1, 0.2, 0.4, 0.6, 1.0})
    {
        const double sigma = percent / 100 * diagonal;
        Points five = shapes::with_noisy_copies(exact, sigma, keep_exact ? 4 : 5, seed);
        if (!keep_exact)
            five.erase(five.begin(), five.begin() + std::ptrdiff_t(exact.size()));
        const Points one = shapes::with_noise(exact, sigma, seed + 1);
        NoiseOptions options;
        options.threads = 1;
        const NoiseEstimate of_one = estimate_noise(one, options);
        std::printf(" %.2f, %.2f (%.2f) |", estimate(five) / sigma, of_one.median_sigma() / sigma,
                    sigma / of_one.median_spacing());
    }
    std::printf("\n");
    std::fflush(stdout);
}

double rms_after(const Points& points, double given, const Vector& sides)
{
    AmlsOptions options;
    options.threads = 1;
    options.noise = given;
    AmlsProjectionOptions project_options;
    project_options.threads = 1;
    return shapes::rms(project_to_amls(points, build_amls_surface(points, options), project_options).points,
                       [&](const Point& p) { return shapes::distance_to_box(p, sides); });
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 2)
    {
        std::fprintf(stderr, "usage: %s <model folder>\n", argv[0]);
        return 2;
    }
    for (const std::string& name : benchmarks::grid_b)
    {
        const benchmarks::Model model = benchmarks::load_model(std::string(argv[1]) + "/" + name + ".ply");
        print_row(name.c_str(), model.mesh.vertices, model.diagonal, true);
    }
    const int n = 10000;
    const auto print_shape = [](const char* name, const Points& exact)
    { print_row(name, exact, bounding_box(exact).diagonal(), false); };
    print_shape("sphere", shapes::sphere(n, 1, seed).points);
    print_shape("box 1.5, 1, 0.7", shapes::box(n, {1.5, 1, 0.7}, seed).points);
    print_shape("torus 1, 0.15", shapes::torus(n, 1, 0.15, seed).points);
    print_shape("capsule 1, 0.1", shapes::capsule(n, 0.1, 1, seed).points);
    print_shape("ellipsoid 1, 0.3, 0.1", shapes::ellipsoid(n, {1, 0.3, 0.1}, seed).points);

    // Plates of one sample a unit of area.
    for (const double wall : {1.0, 1.1, 1.25, 1.5, 2.0})
        for (const double noise : {0.1, 0.2, 0.3, 0.4, 0.5})
        {
            const Vector sides(50, 50, wall);
            const Points plate = shapes::with_noise(shapes::box(int(5000 + 200 * wall), sides, 5).points, noise, 6);
            std::printf("| %.2f | %.1f | %.2f | %.3f | %.3f | %.3f |\n", wall, noise, estimate(plate),
                        shapes::rms(plate, [&](const Point& p) { return shapes::distance_to_box(p, sides); }),
                        rms_after(plate, 0, sides), rms_after(plate, noise, sides));
            std::fflush(stdout);
        }
}
