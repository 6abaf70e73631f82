// Outliers of clouds of uneven density, found and mistaken, on shapes whose distance is known exactly.
// amls_outliers [seeds]: both without noise and with 0.3 spacings of full density
#include "models.h"

#include "tests/shapes.h"

#include "filter_amls/surface/project.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

using namespace recon;

namespace
{

constexpr double pi = 3.14159265358979323846;

/// A surface, and the share of evenly spread samples that are kept at a place of it.
struct Shape
{
    const char* name;
    double area;
    std::function<Points(int, unsigned)> sample;
    std::function<double(const Point&)> distance, kept;
};

using shapes::uniform;

double sphere_area(double radius)
{
    return 4 * pi * radius * radius;
}

double capsule_area(double radius, double half_length)
{
    return sphere_area(radius) + 4 * pi * radius * half_length;
}

/// A body with two thin limbs that start a little off it, each `limb_radius` thick.
struct Figure
{
    static constexpr double radius = 0.4, half_length = 0.6, limb_radius = 0.07, limb_half = 0.5, offset = 1.1;

    static Point in_limb(const Point& p, double side) { return {p.y(), p.z(), p.x() - side * offset}; }
    static double limb_distance(const Point& p)
    {
        return std::min(shapes::distance_to_capsule(in_limb(p, 1), limb_radius, limb_half),
                        shapes::distance_to_capsule(in_limb(p, -1), limb_radius, limb_half));
    }
    static double body_distance(const Point& p) { return shapes::distance_to_capsule(p, radius, half_length); }
    static double area() { return capsule_area(radius, half_length) + 2 * capsule_area(limb_radius, limb_half); }
    static Points sample(int n, unsigned seed)
    {
        const auto share = [&](double part) { return int(std::lround(n * part / area())); };
        Points points = shapes::capsule(share(capsule_area(radius, half_length)), radius, half_length, seed).points;
        for (const double side : {-1.0, 1.0})
            for (const Point& p :
                 shapes::capsule(share(capsule_area(limb_radius, limb_half)), limb_radius, limb_half, seed + 1).points)
                points.push_back({p.z() + side * offset, p.x(), p.y()});
        return points;
    }
};

std::vector<Shape> make_shapes()
{
    const auto sphere = [](int n, unsigned seed) { return shapes::sphere(n, 1, seed).points; };
    const auto to_sphere = [](const Point& p) { return shapes::distance_to_sphere(p, 1); };
    const Vector sides(1.5, 1, 0.7);
    const auto two_spheres = [](int n, unsigned seed)
    {
        Points points = shapes::sphere(n / 2, 1, seed).points;
        for (const Point& p : shapes::sphere(n / 2, 1, seed + 1).points)
            points.push_back(p + Vector(2.5, 0, 0));
        return points;
    };
    const auto side_of = [sides](const Point& p)
    {
        int axis = 0;
        (2 * p.array().abs() / sides.array()).maxCoeff(&axis);
        return 2 * axis + (p[axis] > 0);
    };
    const auto to_torus = [](const Point& p) { return shapes::distance_to_torus(p, 1, 0.4); };
    return {
        {"even sphere", sphere_area(1), sphere, to_sphere, [](const Point&) { return 1.0 / 5; }},
        {"belt 1/12", sphere_area(1), sphere, to_sphere,
         [](const Point& p) { return std::abs(p.z()) < 0.1 ? 1.0 : 1.0 / 12; }},
        {"half 1/50", sphere_area(1), sphere, to_sphere, [](const Point& p) { return p.z() > 0 ? 1.0 : 1.0 / 50; }},
        {"gradient 1/50", sphere_area(1), sphere, to_sphere,
         [](const Point& p) { return std::pow(0.02, (1 + p.z() / std::max(p.norm(), 1e-9)) / 2); }},
        {"streaks 1/30", sphere_area(1), sphere, to_sphere,
         [](const Point& p)
         {
             const double turns = 4 * std::atan2(p.y(), p.x()) / pi, off = std::abs(turns - std::round(turns));
             return off * pi / 4 * std::hypot(p.x(), p.y()) < 0.03 ? 1.0 : 1.0 / 30;
         }},
        {"patches 1/20", sphere_area(1), sphere, to_sphere,
         [](const Point& p)
         { return std::sin(7 * p.x()) * std::sin(7 * p.y()) * std::sin(7 * p.z()) > 0.2 ? 1.0 : 0.05; }},
        {"box, faces 1 to 1/50", 2 * (1.5 + 1.05 + 0.7),
         [sides](int n, unsigned seed) { return shapes::box(n, sides, seed).points; },
         [sides](const Point& p) { return shapes::distance_to_box(p, sides); },
         [side_of](const Point& p) { return std::pow(50.0, -side_of(p) / 5.0); }},
        {"torus, sector 1/50", 4 * pi * pi * 0.4,
         [](int n, unsigned seed) { return shapes::torus(n, 1, 0.4, seed).points; }, to_torus,
         [](const Point& p) { return std::atan2(p.y(), p.x()) > 0.5 ? 1.0 / 50 : 1.0; }},
        {"limbs 1/8", Figure::area(), Figure::sample,
         [](const Point& p) { return std::min(Figure::body_distance(p), Figure::limb_distance(p)); },
         [](const Point& p) { return Figure::body_distance(p) < Figure::limb_distance(p) ? 1.0 : 1.0 / 8; }},
        {"two spheres, 1/50", 2 * sphere_area(1), two_spheres,
         [](const Point& p)
         { return std::min(shapes::distance_to_sphere(p, 1), shapes::distance_to_sphere(p - Vector(2.5, 0, 0), 1)); },
         [](const Point& p) { return p.x() < 1.25 ? 1.0 : 1.0 / 50; }},
    };
}

struct Score
{
    std::size_t good = 0;
    int mistaken = 0, far = 0, far_found = 0;
};

/// \param even number of samples that full density has. \param noise [spacings of full density].
Score judge(const Shape& shape, int even, double noise, double share, unsigned seed)
{
    const double spacing = std::sqrt(shape.area / even), sigma = noise * spacing;
    Points points;
    shapes::Random random(seed);
    for (const Point& p : shape.sample(even, seed + 1))
        if (uniform(random) < shape.kept(p))
            points.push_back(p);
    points = shapes::with_noise(points, sigma, seed + 2);
    Score score;
    score.good = points.size();
    points = benchmarks::with_outliers(points, share, seed + 3);
    AmlsOptions options;
    options.threads = 1;
    AmlsProjectionOptions project_options;
    project_options.threads = 1;
    const AmlsProjection projection = project_to_amls(points, build_amls_surface(points, options), project_options);
    for (std::size_t i = 0; i < points.size(); ++i)
    {
        const bool flagged = projection.status[i] == ProjectionStatus::outlier;
        if (i < score.good)
        {
            score.mistaken += flagged;
            continue;
        }
        // Nearer ones are as good as samples.
        if (shape.distance(points[i]) > std::max(3 * spacing / std::sqrt(shape.kept(points[i])), 6 * sigma))
        {
            ++score.far;
            score.far_found += flagged;
        }
    }
    return score;
}

/// Single points off a clean sphere, far from each other: how many are told as outliers, by their distance.
void judge_lone_points(unsigned seed)
{
    for (const double noise : {0.0, 0.1, 0.3})
    {
        std::printf("| lone points | %.1f |", noise);
        for (const double off : {2.0, 3.0, 4.0, 6.0, 10.0})
        {
            const double spacing = std::sqrt(sphere_area(1) / 8000);
            Points points = shapes::with_noise(shapes::sphere(8000, 1, seed).points, noise * spacing, seed + 1);
            const std::size_t good = points.size();
            for (const Point& p : shapes::sphere(12, 1 + off * spacing, seed + 2).points)
                points.push_back(p);
            AmlsOptions options;
            options.threads = 1;
            AmlsProjectionOptions project_options;
            project_options.threads = 1;
            const AmlsProjection projection =
                project_to_amls(points, build_amls_surface(points, options), project_options);
            const auto outliers = [&](std::size_t begin, std::size_t end)
            {
                return int(std::count(projection.status.begin() + std::ptrdiff_t(begin),
                                      projection.status.begin() + std::ptrdiff_t(end), ProjectionStatus::outlier));
            };
            std::printf(" at %g: %d of 12, mistaken %d |", off, outliers(good, points.size()), outliers(0, good));
        }
        std::printf("\n");
        std::fflush(stdout);
    }
}

} // namespace

int main(int argc, char** argv)
{
    const int seeds = argc > 1 ? std::stoi(argv[1]) : 2;
    for (int s = 1; s <= seeds; ++s)
        judge_lone_points(unsigned(100 * s + 7));
    std::printf("| shape | samples | mistaken: no outliers | with 1 %% | far found | with 5 %% | far found |\n");
    for (const Shape& shape : make_shapes())
        for (const int even : {8000, 60000})
        {
            std::printf("| %s | %d |", shape.name, even);
            for (const double share : {0.0, 0.01, 0.05})
            {
                Score sum;
                for (int s = 1; s <= seeds; ++s)
                    for (const double noise : {0.0, 0.3})
                    {
                        const Score one = judge(shape, even, noise, share, unsigned(100 * s + 21));
                        sum.good += one.good;
                        sum.mistaken += one.mistaken;
                        sum.far += one.far;
                        sum.far_found += one.far_found;
                    }
                if (share == 0)
                    std::printf(" %d of %zu |", sum.mistaken, sum.good);
                else
                    std::printf(" %d | %d of %d |", sum.mistaken, sum.far_found, sum.far);
            }
            std::printf("\n");
            std::fflush(stdout);
        }
}
