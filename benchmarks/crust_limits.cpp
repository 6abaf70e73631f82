// Where the noisy power crust stops working, on shapes of known topology: crust_limits <seed>
// [sheet|gap|torus|rings|hole|fins]
//   sheet: a plate of thickness t. gap: two balls whose surfaces are t apart. torus: tube of diameter t. rings: the
//   same in rings of points, as vertices of a mesh lie. hole: a plate 3 spacings thick with 3 x 3 holes of diameter t.
//   fins: eight on a base, walls and gaps t thick. t in spacings of the samples; noise in spacings too; 5 noisy samples
//   a spot where there is noise, as in the grids. Prints "shape noise t right-of-trials".
#include "filter_noisy_powercrust/reconstruct.h"
#include "tests/checks.h"
#include "tests/shapes.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

using recon::Point;
using recon::Points;

namespace
{

constexpr double pi = 3.14159265358979323846;

struct Shape
{
    Points points;
    int components, euler;
};

Shape make(const std::string& name, double t, unsigned seed)
{
    if (name == "sheet")
        return {shapes::plate(24, t, {}, 0, seed), 1, 2};
    if (name == "hole")
        return {shapes::bored_plate(3, t, seed), 1, 2 - 2 * 9};
    if (name == "fins")
        return {shapes::HeatSink(8, t, t, 14, 25, 4, seed).points, 1, 2};
    if (name == "rings")
        return {shapes::torus_of_rings(12 + 10 * (seed % 3), 0.5 * t).points, 1, 0};
    shapes::PoissonDisks disks(1, seed);
    const auto direction = [&]
    {
        const double z = 2 * disks.uniform() - 1, angle = 2 * pi * disks.uniform(), r = std::sqrt(1 - z * z);
        return Point(r * std::cos(angle), r * std::sin(angle), z);
    };
    if (name == "gap")
    {
        Shape shape{{}, 2, 4};
        const double radius = 8;
        for (const double side : {-1, 1})
        {
            Points ball;
            disks.fill([&]() -> Point { return radius * direction() + Point(side * (radius + 0.5 * t), 0, 0); },
                       int(12 * 4 * pi * radius * radius), ball);
            shape.points.insert(shape.points.end(), ball.begin(), ball.end());
        }
        return shape;
    }
    Shape shape{{}, 1, 0};
    const double major = 12, minor = 0.5 * t;
    disks.fill(
        [&]
        {
            double u = 0, v = 0;
            do
            {
                u = 2 * pi * disks.uniform();
                v = 2 * pi * disks.uniform();
            } while (disks.uniform() * (major + minor) > major + minor * std::cos(v));
            const double r = major + minor * std::cos(v);
            return Point(r * std::cos(u), r * std::sin(u), minor * std::sin(v));
        },
        int(12 * 4 * pi * pi * major * minor), shape.points);
    return shape;
}

bool is_right(const Shape& shape, double noise, unsigned seed)
{
    recon::NoisyPowerCrustOptions options;
    options.threads = 1;
    options.keep_components = recon::KeepComponents::all;
    try
    {
        const Points cloud = noise > 0 ? shapes::with_noisy_copies(shape.points, noise, 4, seed) : shape.points;
        const checks::MeshReport report =
            checks::examine_mesh(recon::reconstruct_noisy_power_crust(cloud, options).mesh);
        return report.is_closed_oriented_manifold() && report.components == shape.components &&
               report.euler_characteristic == shape.euler && report.volume > 0;
    }
    catch (const std::exception&)
    {
        return false;
    }
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 2)
    {
        std::fprintf(stderr, "usage: %s <seed> [sheet|gap|torus|rings|hole|fins]\n", argv[0]);
        return 2;
    }
    const unsigned seed = unsigned(std::atoi(argv[1]));
    constexpr int trials = 3;
    for (const std::string name : {"sheet", "gap", "torus", "rings", "hole", "fins"})
        if (argc < 3 || name == argv[2])
            for (const double noise : {0.0, 0.1, 0.2, 0.4})
                for (const double t : {0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0})
                {
                    int right = 0;
                    for (unsigned k = 0; k < trials; ++k)
                        right += is_right(make(name, t, seed + k), noise, seed + 100 + k);
                    std::printf("%s %.2f %.2f %d %d\n", name.c_str(), noise, t, right, trials);
                    std::fflush(stdout);
                }
}
