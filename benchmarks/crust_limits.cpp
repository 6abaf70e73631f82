// Where the noisy power crust stops working, on shapes of known topology: crust_limits <seed> [sheet|gap|torus|hole]
//   sheet: a plate of thickness t. gap: two balls whose surfaces are t apart. torus: tube of diameter t. hole: a plate
//   3 spacings thick with 3 x 3 holes of diameter t. t in spacings of the samples; noise in spacings too; 5 noisy
//   samples a spot where there is noise, as in the grids. Prints "shape noise t right-of-trials".
#include "filter_noisy_powercrust/reconstruct.h"
#include "tests/checks.h"
#include "tests/shapes.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <string>

using recon::Point;
using recon::Points;

namespace
{

constexpr double pi = 3.14159265358979323846;

/// Keeps a random order's points that are at least `spacing` from all kept ones: even samples without a lattice.
class PoissonDisks
{
public:
    PoissonDisks(double spacing, unsigned seed) : spacing_(spacing), random_(seed) {}
    double uniform() { return shapes::uniform(random_); }
    /// Draws from `draw` until `misses` draws in a row were too near.
    void fill(const std::function<Point()>& draw, int tries, Points& points)
    {
        const std::size_t begin = points.size();
        for (int i = 0; i < tries; ++i)
        {
            const Point p = draw();
            bool is_free = true;
            for (std::size_t k = begin; k < points.size() && is_free; ++k)
                is_free = (points[k] - p).squaredNorm() > 0.64 * spacing_ * spacing_;
            if (is_free)
                points.push_back(p);
        }
    }

private:
    double spacing_;
    shapes::Random random_;
};

struct Shape
{
    Points points;
    int components, euler;
};

/// A plate of sides a x a x t around the origin, with holes of diameter d at the given centres, walls of the holes
/// included.
Shape plate(double a, double t, const Points& holes, double d, unsigned seed)
{
    PoissonDisks disks(1, seed);
    Shape shape{{}, 1, 2 - 2 * int(holes.size())};
    for (const double side : {-0.5, 0.5})
    {
        Points face;
        disks.fill(
            [&]
            {
                Point p;
                bool in_hole = true;
                while (in_hole)
                {
                    p = Point(a * (disks.uniform() - 0.5), a * (disks.uniform() - 0.5), side * t);
                    in_hole = false;
                    for (const Point& h : holes)
                        in_hole |= (p - h).head<2>().norm() < 0.5 * d;
                }
                return p;
            },
            int(12 * a * a), face);
        shape.points.insert(shape.points.end(), face.begin(), face.end());
    }
    Points rim;
    disks.fill(
        [&]
        {
            const int edge = int(4 * disks.uniform());
            const double along = a * (disks.uniform() - 0.5), z = t * (disks.uniform() - 0.5),
                         across = edge % 2 ? 0.5 * a : -0.5 * a;
            return edge < 2 ? Point(across, along, z) : Point(along, across, z);
        },
        int(12 * 4 * a * std::max(t, 0.5)), rim);
    for (const Point& h : holes)
        disks.fill(
            [&]
            {
                const double angle = 2 * pi * disks.uniform();
                return Point(h.x() + 0.5 * d * std::cos(angle), h.y() + 0.5 * d * std::sin(angle),
                             t * (disks.uniform() - 0.5));
            },
            int(12 * pi * d * std::max(t, 0.5)), rim);
    shape.points.insert(shape.points.end(), rim.begin(), rim.end());
    return shape;
}

Shape make(const std::string& name, double t, unsigned seed)
{
    if (name == "sheet")
        return plate(24, t, {}, 0, seed);
    if (name == "hole")
    {
        Points holes;
        for (int i = -1; i <= 1; ++i)
            for (int j = -1; j <= 1; ++j)
                holes.push_back(Point(9 * i, 9 * j, 0));
        return plate(30, 3, holes, t, seed);
    }
    PoissonDisks disks(1, seed);
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
        std::fprintf(stderr, "usage: %s <seed> [sheet|gap|torus|hole]\n", argv[0]);
        return 2;
    }
    const unsigned seed = unsigned(std::atoi(argv[1]));
    constexpr int trials = 3;
    for (const std::string name : {"sheet", "gap", "torus", "hole"})
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
