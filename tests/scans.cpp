#include "scans.h"

#include "shapes.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace shapes
{

using recon::OrientedSamples;
using recon::Point;
using recon::Vector;

namespace
{

constexpr double pi = 3.14159265358979323846;

} // namespace

OrientedSamples depth_frame(int columns, double step, std::uint64_t seed)
{
    Random random(seed);
    const double pixel = 1.0 / columns, radius = 0.4, height = 0.6;
    const Point ball(0.4, 0.2, 2.6);
    OrientedSamples frame;
    for (int i = 0; i < columns * 3 / 4; ++i)
        for (int j = 0; j < columns; ++j)
        {
            const Vector ray((j - columns / 2.0) * pixel, (i - columns * 3 / 8.0) * pixel, 1);
            double depth = 4;
            Vector normal(0, 0, -1);
            if (ray.y() * depth > height)
            {
                depth = height / ray.y();
                normal = -Vector::UnitY();
            }
            const double along = ray.dot(ball),
                         under = along * along - ray.squaredNorm() * (ball.squaredNorm() - radius * radius);
            if (under > 0)
            {
                depth = (along - std::sqrt(under)) / ray.squaredNorm();
                normal = (depth * ray - ball).normalized();
            }
            depth = 1 / (step * std::round(1 / (step * depth) + uniform(random) - 0.5));
            frame.points.push_back(depth * ray);
            frame.normals.push_back(normal);
        }
    return frame;
}

OrientedSamples laser_scan(int around, double noise, bool in_room, std::uint64_t seed, const Point& place,
                           const std::vector<recon::Box>& boxes)
{
    Random random(seed);
    const double step = 2 * pi / around, radius = 0.5;
    const Point ball = Point(1.6, 1.2, -1) - place, low = Point(-3, -2.5, -1.5) - place,
                high = Point(2.5, 3, 1.3) - place;
    OrientedSamples scan;
    for (int i = 0; i < around / 3; ++i)
        for (int j = 0; j < around; ++j)
        {
            const double over = (i - around / 6) * step, about = j * step;
            const Vector ray(std::cos(over) * std::cos(about), std::cos(over) * std::sin(about), std::sin(over));
            double range = 1e300;
            Vector normal;
            for (int axis = 0; axis < 3; ++axis)
            {
                const double end = (ray[axis] < 0 ? low : high)[axis] / ray[axis];
                const bool is_floor = axis == 2 && ray.z() < 0;
                if (end < range && (is_floor || in_room))
                {
                    range = end;
                    normal = Vector::Unit(axis) * (ray[axis] < 0 ? 1 : -1);
                }
            }
            const double along = ray.dot(ball), under = along * along - (ball.squaredNorm() - radius * radius);
            if (under > 0 && along > 0)
            {
                range = along - std::sqrt(under);
                normal = (range * ray - ball).normalized();
            }
            for (const recon::Box& box : boxes)
            {
                double enters = 0, leaves = 1e300;
                int through = 0;
                for (int axis = 0; axis < 3; ++axis)
                {
                    const double one = (box.minimum[axis] - place[axis]) / ray[axis],
                                 other = (box.maximum[axis] - place[axis]) / ray[axis];
                    leaves = std::min(leaves, std::max(one, other));
                    if (std::min(one, other) > enters)
                    {
                        enters = std::min(one, other);
                        through = axis;
                    }
                }
                if (enters > 0 && enters < std::min(leaves, range))
                {
                    range = enters;
                    normal = Vector::Unit(through) * (ray[through] < 0 ? 1 : -1);
                }
            }
            if (!in_room && range > 4)
                continue;
            range += noise * (2 * (uniform(random) + uniform(random) + uniform(random)) - 3);
            scan.points.push_back(place + range * ray);
            scan.normals.push_back(normal);
        }
    return scan;
}

OrientedSamples scan_by_beams(int around, int stride, double noise, std::uint64_t seed, double lowest, double highest)
{
    const OrientedSamples scan = laser_scan(around, noise, true, seed);
    OrientedSamples beams;
    for (std::size_t i = 0; i < scan.points.size(); ++i)
    {
        const Point& p = scan.points[i];
        const double above = std::asin(p.z() / p.norm()) * 180 / pi;
        if (int(i) / around % stride != 0 || above < lowest || above > highest) // every ray of a room hits
            continue;
        beams.points.push_back(p);
        beams.normals.push_back(scan.normals[i]);
    }
    return beams;
}

OrientedSamples laser_scans(int around, double noise, bool in_room, std::uint64_t seed, const recon::Points& places)
{
    OrientedSamples scans;
    for (const Point& place : places)
    {
        const OrientedSamples scan = laser_scan(around, noise, in_room, seed, place);
        scans.points.insert(scans.points.end(), scan.points.begin(), scan.points.end());
        scans.normals.insert(scans.normals.end(), scan.normals.begin(), scan.normals.end());
    }
    return scans;
}

OrientedSamples views_out_of_register(const OrientedSamples& surface, int views, double kept, double off_by,
                                      std::uint64_t seed)
{
    constexpr double golden_angle = 2.399963229728653, least_slope = 0.25;
    double farthest = 0;
    for (const Point& p : surface.points)
        farthest = std::max(farthest, p.norm());
    Random random(seed);
    OrientedSamples seen;
    for (int view = 0; view < views; ++view)
    {
        const double z = 1 - (2 * view + 1.0) / views, angle = view * golden_angle, r = std::sqrt(1 - z * z);
        const Vector towards(r * std::cos(angle), r * std::sin(angle), z);
        const recon::Points moves =
            with_noise(recon::Points(2, Point::Zero()), off_by / std::sqrt(3.0), seed + 1 + std::uint64_t(view));
        const Vector shift = moves[0], turn = moves[1] / farthest;
        for (std::size_t i = 0; i < surface.points.size(); ++i)
        {
            const Point& p = surface.points[i];
            const Vector& normal = surface.normals[i];
            if (normal.dot(towards) < least_slope || uniform(random) > kept)
                continue;
            seen.points.push_back(p + shift + turn.cross(p));
            seen.normals.push_back((normal + turn.cross(normal)).normalized());
        }
    }
    return seen;
}

OrientedSamples torus_out_of_register(std::uint64_t seed)
{
    OrientedSamples seen = views_out_of_register(torus(5000, 1, 0.4, seed), 8, 0.6, 0.12, seed);
    seen.points = with_noise(seen.points, 0.008, seed);
    return seen;
}

} // namespace shapes
