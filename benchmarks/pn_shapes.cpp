// PN refinement of shapes that are known exactly, step by step. Usage: pn_shapes [steps]
#include "pn_models.h"

#include "tests/shapes.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>

using namespace benchmarks;
using recon::OrientedSamples;
using recon::Point;
using recon::Vector;

namespace
{

struct Shape
{
    const char* name;
    OrientedSamples samples, surface; ///< The surface: where gaps are looked for.
    double area;
    std::function<double(const Point&)> distance;
    std::function<Vector(const Point&)> normal;
    /// Samples per area, in their mean: gaps are measured in the spacing that belongs to it.
    std::function<double(const Point&)> density = [](const Point&) { return 1.0; };
};

OrientedSamples keep(const OrientedSamples& from, const std::function<bool(const Point&)>& is_kept)
{
    OrientedSamples kept;
    for (std::size_t i = 0; i < from.points.size(); ++i)
        if (is_kept(from.points[i]))
        {
            kept.points.push_back(from.points[i]);
            kept.normals.push_back(from.normals[i]);
        }
    return kept;
}

void measure(const Shape& shape, int steps)
{
    std::printf("%s, %zu points\n", shape.name, shape.samples.points.size());
    const double diagonal = recon::bounding_box(shape.samples.points).diagonal();
    for (int l = 1; l <= steps; ++l)
    {
        recon::PnRefineOptions options;
        options.steps = l;
        options.threads = 1;
        const recon::PnRefinement refined = recon::refine_points(shape.samples, options);
        const OrientedSamples all = join(shape.samples, refined);
        const double spacing = std::sqrt(shape.area / double(all.points.size()));
        double sum = 0, most = 0, angles = 0;
        for (std::size_t i = 0; i < refined.points.size(); ++i)
        {
            const double d = shape.distance(refined.points[i]);
            sum += d * d;
            most = std::max(most, d);
            const double a =
                std::acos(std::min(1.0, refined.normals[i].dot(shape.normal(refined.points[i])))) * 180 / M_PI;
            angles += a * a;
        }
        const double n = double(refined.points.size());
        std::printf("  %d %8zu | RMS %.2e max %.2e of the diagonal, normals %.4f degrees | gap %.2f pair %.3f spacings "
                    "| radii %.4f "
                    "%.4f open %d\n",
                    l, all.points.size(), std::sqrt(sum / n) / diagonal, most / diagonal, std::sqrt(angles / n),
                    largest_gap(shape.surface, all, 1, [&](const Point& p) { return std::sqrt(shape.density(p)); }) /
                        spacing,
                    closest_pair(shape.samples, refined.points) / spacing, refined.steps.back().median_radius,
                    refined.steps.back().largest_radius, refined.steps.back().open_gaps);
        std::fflush(stdout);
    }
}

} // namespace

int main(int argc, char** argv)
{
    const int steps = argc > 1 ? std::atoi(argv[1]) : 6;
    const auto sphere_distance = [](const Point& p) { return shapes::distance_to_sphere(p, 1); };
    const auto sphere_normal = [](const Point& p) { return Vector(p.normalized()); };
    const double sphere_area = 4 * M_PI;
    const OrientedSamples dense = shapes::sphere(300000, 1, 99), sphere = shapes::sphere(3500, 1, 1);
    measure({"sphere", sphere, dense, sphere_area, sphere_distance, sphere_normal}, steps);

    const auto torus_normal = [](const Point& p)
    {
        const Vector ring = Vector(p.x(), p.y(), 0).normalized();
        return Vector((p - ring).normalized());
    };
    measure({"torus 1, 0.4", shapes::torus(3500, 1, 0.4, 1), shapes::torus(300000, 1, 0.4, 99), 4 * M_PI * M_PI * 0.4,
             [](const Point& p) { return shapes::distance_to_torus(p, 1, 0.4); }, torus_normal},
            steps);

    shapes::Random random(5);
    const auto share = [](const Point& p) { return std::pow(10, -(p.z() + 1)); };
    const double mean_share = 0.99 / (2 * std::log(10.0));
    measure({"sphere, 100 times denser at one pole (pair in spacings of the whole)",
             keep(shapes::sphere(60000, 1, 2), [&](const Point& p) { return shapes::uniform(random) < share(p); }),
             dense, sphere_area, sphere_distance, sphere_normal, [&](const Point& p) { return share(p) / mean_share; }},
            std::min(steps, 4));

    OrientedSamples half = keep(shapes::sphere(3500, 1, 2), [](const Point& p) { return p.z() >= 0; });
    const OrientedSamples inner = keep(dense, [](const Point& p) { return p.z() > 0.12; });
    measure({"hemisphere, ragged rim", half, inner, sphere_area / 2, sphere_distance, sphere_normal}, steps);
    for (int i = 0; i < 105; ++i)
    {
        const double a = 2 * M_PI * i / 105;
        half.points.emplace_back(std::cos(a), std::sin(a), 0);
        half.normals.push_back(half.points.back());
    }
    measure({"hemisphere, clean rim", half, keep(dense, [](const Point& p) { return p.z() > 0; }), sphere_area / 2,
             sphere_distance, sphere_normal},
            steps);

    OrientedSamples grid, plane;
    for (int x = 0; x < 50; ++x)
        for (int y = 0; y < 50; ++y)
        {
            grid.points.emplace_back(x, y, 0);
            grid.normals.push_back(Vector::UnitZ());
        }
    for (int i = 0; i < 200000; ++i)
    {
        const double x = shapes::uniform(random), y = shapes::uniform(random);
        plane.points.emplace_back(49 * x, 49 * y, 0);
        plane.normals.push_back(Vector::UnitZ());
    }
    measure({"grid in a plane", grid, plane, 49 * 49, [](const Point& p) { return std::abs(p.z()); },
             [](const Point&) { return Vector(Vector::UnitZ()); }},
            std::min(steps, 5));
}
