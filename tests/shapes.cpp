#include "shapes.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace shapes
{
namespace
{

using recon::OrientedSamples;
using recon::Point;
using recon::Points;
using recon::Vector;

constexpr double pi = 3.14159265358979323846;

Vector direction(Random& random)
{
    const double z = 2 * uniform(random) - 1, angle = 2 * pi * uniform(random), r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
}

} // namespace

double uniform(Random& random)
{
    return double(random() >> 11) * 0x1p-53;
}

Points scattered(int n, const Vector& sides, std::uint64_t seed)
{
    Random random(seed);
    Points points(std::size_t(n), Point::Zero());
    for (Point& p : points)
        for (int k = 0; k < 3; ++k)
            p[k] = sides[k] * uniform(random) - 0.5 * sides[k];
    return points;
}

OrientedSamples sphere(int n, double radius, std::uint64_t seed)
{
    return ellipsoid(n, Vector::Constant(radius), seed);
}

OrientedSamples ellipsoid(int n, const Vector& half_axes, std::uint64_t seed)
{
    Random random(seed);
    OrientedSamples samples;
    const double shortest = half_axes.minCoeff();
    while (int(samples.points.size()) < n)
    {
        const Vector u = direction(random);
        // Area grows by abc |u / axes|; at most abc / shortest axis.
        const Vector scaled = u.cwiseQuotient(half_axes);
        if (uniform(random) > scaled.norm() * shortest)
            continue;
        samples.points.push_back(u.cwiseProduct(half_axes));
        samples.normals.push_back(scaled.normalized());
    }
    return samples;
}

Points sphere_below(double z, int n, double radius, std::uint64_t seed)
{
    Points result;
    for (const Point& p : sphere(n, radius, seed).points)
        if (p.z() < z)
            result.push_back(p);
    return result;
}

namespace
{

void append_torus_point(double major, double minor, double u, double v, OrientedSamples& samples)
{
    const Vector normal(std::cos(u) * std::cos(v), std::sin(u) * std::cos(v), std::sin(v));
    samples.points.push_back(Vector(major * std::cos(u), major * std::sin(u), 0) + minor * normal);
    samples.normals.push_back(normal);
}

} // namespace

OrientedSamples torus(int n, double major, double minor, std::uint64_t seed)
{
    Random random(seed);
    OrientedSamples samples;
    while (int(samples.points.size()) < n)
    {
        const double u = 2 * pi * uniform(random), v = 2 * pi * uniform(random);
        if (uniform(random) <= (major + minor * std::cos(v)) / (major + minor))
            append_torus_point(major, minor, u, v, samples);
    }
    return samples;
}

OrientedSamples torus_of_rings(double major, double minor)
{
    const int rings = int(2 * pi * major), around = int(2 * pi * minor + 0.5);
    OrientedSamples samples;
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < around; ++j)
            append_torus_point(major, minor, 2 * pi * i / rings, 2 * pi * j / around, samples);
    return samples;
}

Points even_torus(double major, double minor, std::uint64_t seed)
{
    PoissonDisks disks(1, seed);
    const OrientedSamples draws = torus(int(12 * 4 * pi * pi * major * minor), major, minor, seed);
    std::size_t next = 0;
    Points points;
    disks.fill([&] { return draws.points[next++]; }, int(draws.points.size()), points);
    return points;
}

OrientedSamples box(int n, const Vector& sides, std::uint64_t seed)
{
    Random random(seed);
    OrientedSamples samples;
    const Vector area(sides.y() * sides.z(), sides.z() * sides.x(), sides.x() * sides.y());
    for (int i = 0; i < n; ++i)
    {
        double pick = uniform(random) * area.sum();
        int axis = 0;
        while (axis < 2 && pick > area[axis])
            pick -= area[axis++];
        const double side = random() % 2 == 0 ? -1 : 1;
        Point p;
        for (int k = 0; k < 3; ++k)
            p[k] = (k == axis ? 0.5 * side : uniform(random) - 0.5) * sides[k];
        samples.points.push_back(p);
        samples.normals.push_back(side * Vector::Unit(axis));
    }
    return samples;
}

OrientedSamples capsule(int n, double radius, double half_length, std::uint64_t seed)
{
    Random random(seed);
    OrientedSamples samples;
    for (int i = 0; i < n; ++i)
    {
        const double angle = 2 * pi * uniform(random);
        if (uniform(random) * (half_length + radius) < half_length)
        {
            const Vector normal(std::cos(angle), std::sin(angle), 0);
            samples.points.push_back(radius * normal + Vector(0, 0, (2 * uniform(random) - 1) * half_length));
            samples.normals.push_back(normal);
        }
        else
        {
            const Vector normal = direction(random);
            samples.points.push_back(radius * normal + Vector(0, 0, std::copysign(half_length, normal.z())));
            samples.normals.push_back(normal);
        }
    }
    return samples;
}

OrientedSamples tube(int n, double radius, double wall, double half_length, std::uint64_t seed)
{
    Random random(seed);
    OrientedSamples samples;
    const double inner = radius - wall, middle = radius - wall / 2;
    for (int i = 0; i < n; ++i)
    {
        const double angle = 2 * pi * uniform(random);
        const Vector radial(std::cos(angle), std::sin(angle), 0);
        const double share = uniform(random) * middle * (2 * half_length + wall);
        if (share < 2 * middle * half_length)
        {
            const bool is_outer = share < radius * half_length;
            samples.points.push_back((is_outer ? radius : inner) * radial +
                                     Vector(0, 0, (2 * uniform(random) - 1) * half_length));
            samples.normals.push_back(is_outer ? radial : Vector(-radial));
        }
        else
        {
            const double side = uniform(random) < 0.5 ? -1 : 1;
            const double r = std::sqrt(inner * inner + (radius * radius - inner * inner) * uniform(random));
            samples.points.push_back(r * radial + Vector(0, 0, side * half_length));
            samples.normals.push_back({0, 0, side});
        }
    }
    return samples;
}

OrientedSamples thin_tube(std::uint64_t seed)
{
    return tube(4000, 1, 1.3 * thin_tube_spacing, 1.5, seed);
}

double distance_to_sphere(const Point& p, double radius)
{
    return std::abs(p.norm() - radius);
}

double distance_to_torus(const Point& p, double major, double minor)
{
    return std::abs(std::hypot(p.head<2>().norm() - major, p.z()) - minor);
}

double distance_to_box(const Point& p, const Vector& sides)
{
    const Vector q = p.cwiseAbs() - 0.5 * sides;
    return std::abs(q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0));
}

double distance_to_capsule(const Point& p, double radius, double half_length)
{
    return std::abs((p - Point(0, 0, std::clamp(p.z(), -half_length, half_length))).norm() - radius);
}

void PoissonDisks::fill(const std::function<Point()>& draw, int tries, Points& points)
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

Points plate(double side, double thickness, const Points& bores, double diameter, std::uint64_t seed)
{
    PoissonDisks disks(1, seed);
    Points points;
    for (const double half : {-0.5, 0.5})
        disks.fill(
            [&]
            {
                Point p;
                bool is_in_bore = true;
                while (is_in_bore)
                {
                    p.head<2>() = draw_pair([&] { return side * (disks.uniform() - 0.5); });
                    p.z() = half * thickness;
                    is_in_bore = false;
                    for (const Point& bore : bores)
                        is_in_bore |= (p - bore).head<2>().norm() < 0.5 * diameter;
                }
                return p;
            },
            int(12 * side * side), points);
    disks.fill(
        [&]
        {
            const int edge = int(4 * disks.uniform());
            const double along = side * (disks.uniform() - 0.5), z = thickness * (disks.uniform() - 0.5),
                         across = edge % 2 ? 0.5 * side : -0.5 * side;
            return edge < 2 ? Point(across, along, z) : Point(along, across, z);
        },
        int(12 * 4 * side * std::max(thickness, 0.5)), points);
    for (const Point& bore : bores)
        disks.fill(
            [&]
            {
                const double angle = 2 * pi * disks.uniform();
                return Point(bore.x() + 0.5 * diameter * std::cos(angle), bore.y() + 0.5 * diameter * std::sin(angle),
                             thickness * (disks.uniform() - 0.5));
            },
            int(12 * pi * diameter * std::max(thickness, 0.5)), points);
    return points;
}

Points bored_plate(double thickness, double diameter, std::uint64_t seed)
{
    Points bores;
    for (int i = -1; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j)
            bores.push_back(Point(9 * i, 9 * j, 0));
    return plate(30, thickness, bores, diameter, seed);
}

Points cup_with_wavy_rim(int n, double height, double wave, std::uint64_t seed)
{
    Random random(seed);
    Points points;
    while (int(points.size()) < n)
    {
        const double turn = 2 * pi * uniform(random), along = uniform(random);
        const Point around(std::cos(turn), std::sin(turn), 0);
        if (uniform(random) < 1 / (1 + 2 * (height + wave)))
            points.push_back(std::sqrt(along) * around);
        else if (const double z = along * (height + wave); z < height + wave * std::sin(3 * turn))
            points.push_back(around + Point(0, 0, z));
    }
    return points;
}

Points thin_plate(int side, double thickness, std::uint64_t seed)
{
    return stack_of_sheets(2, side, thickness, seed);
}

Points stack_of_sheets(int sheets, int side, double gap, std::uint64_t seed)
{
    Random random(seed);
    const auto jitter = [&] { return 0.3 * (uniform(random) - 0.5); };
    Points points;
    for (int i = 0; i <= side; ++i)
        for (int j = 0; j <= side; ++j)
            for (int k = 0; k < sheets; ++k)
                points.emplace_back(i + jitter(), j + jitter(), k * gap);
    return points;
}

Points spiky_ball(double width, std::uint64_t seed)
{
    constexpr double radius = 8, length = 7, tip = 0.4;
    constexpr int spikes = 12;
    const double base = 0.5 * width;
    Random random(seed);
    const auto direction = [](double z, double angle) -> Vector
    {
        const double r = std::sqrt(1 - z * z);
        return {r * std::cos(angle), r * std::sin(angle), z};
    };
    recon::Vectors axes;
    for (int k = 0; k < spikes; ++k)
        axes.push_back(direction(2 * (k + 0.5) / spikes - 1, 2.4 * k)); // nearly the golden angle
    Points points;
    for (int i = 0; i < int(4 * pi * radius * radius); ++i)
    {
        const Eigen::Vector2d drawn = draw_pair([&] { return uniform(random); });
        const Vector d = direction(2 * drawn.x() - 1, 2 * pi * drawn.y());
        if (std::none_of(axes.begin(), axes.end(), [&](const Vector& a) { return d.dot(a) > std::cos(base / radius); }))
            points.push_back(radius * d);
    }
    for (const Vector& axis : axes)
    {
        const Vector x = axis.unitOrthogonal(), y = axis.cross(x);
        for (int i = 0; i < int(pi * (base + tip) * length); ++i)
        {
            double along = 0, r = 0;
            do
            {
                along = uniform(random);
                r = base + along * (tip - base);
            } while (uniform(random) * base > r);
            const double angle = 2 * pi * uniform(random);
            points.push_back((radius + along * length) * axis + r * (std::cos(angle) * x + std::sin(angle) * y));
        }
        points.push_back((radius + length) * axis);
    }
    return points;
}

Points ball_with_hairs(std::uint64_t seed)
{
    Points points = sphere(6'000, 1, seed).points;
    Random random(seed);
    for (int axis = 0; axis < 3; ++axis)
        for (const int side : {-1, 1})
            for (int i = 0; i < 30; ++i)
            {
                const double angle = 2 * pi * uniform(random), along = 1 + uniform(random);
                Point p;
                p[axis] = side * along;
                p[(axis + 1) % 3] = 0.02 * std::cos(angle);
                p[(axis + 2) % 3] = 0.02 * std::sin(angle);
                points.push_back(p);
            }
    return points;
}

FinnedBall finned_ball(std::uint64_t seed)
{
    FinnedBall result{sphere(20106, 40, seed), 228};
    Random random(seed + 1);
    for (int i = 0; i < result.fin; ++i)
    {
        const double x = 39 + 19 * uniform(random), z = 12 * uniform(random) - 6;
        result.samples.points.emplace_back(x, 0, z);
        result.samples.normals.emplace_back(0, 1, 0);
    }
    return result;
}

Points ball_on_a_ground(std::uint64_t seed)
{
    Random random(seed);
    const auto jitter = [&] { return 0.6 * (uniform(random) - 0.5); };
    Points points = sphere(1810, 12, seed).points;
    for (Point& p : points)
        p += Point(10, 5, 12);
    for (int i = -50; i <= 50; ++i)
        for (int j = -50; j <= 50; ++j)
            points.emplace_back(i + jitter(), j + jitter(), 0);
    return points;
}

OrientedSamples table_over_a_floor(std::uint64_t seed)
{
    Random random(seed);
    const auto jitter = [&] { return 0.6 * (uniform(random) - 0.5); };
    OrientedSamples scene;
    for (int i = -50; i <= 50; ++i)
        for (int j = -50; j <= 50; ++j)
        {
            const bool is_table = std::abs(i - 5) <= 18 && std::abs(j) <= 14;
            scene.points.emplace_back(i + jitter(), j + jitter(), is_table ? 20 : 0);
            scene.normals.push_back(Vector::UnitZ());
        }
    return scene;
}

OrientedSamples ball_apart_from_a_floor(const Point& centre, double radius, std::uint64_t seed)
{
    OrientedSamples scene = sphere(int(std::lround(4 * pi * radius * radius)), radius, seed);
    for (Point& p : scene.points)
        p += centre;
    const Points ground = ball_on_a_ground(seed);
    scene.points.insert(scene.points.end(), ground.end() - 101 * 101, ground.end());
    scene.normals.resize(scene.points.size(), Vector::UnitZ());
    return scene;
}

double rms(const Points& points, const std::function<double(const Point&)>& distance)
{
    double squares = 0;
    for (const Point& p : points)
        squares += distance(p) * distance(p);
    return std::sqrt(squares / double(points.size()));
}

} // namespace shapes
