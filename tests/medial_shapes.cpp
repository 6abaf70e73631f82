#include "medial_shapes.h"

#include "shapes.h"

#include <recon/search/neighbours.h>

#include <algorithm>
#include <cmath>

using namespace recon;

namespace shapes
{
namespace
{

constexpr double pi = 3.14159265358979323846;

} // namespace

Points MedialShape::noisy(double noise, bool with_copies, std::uint64_t seed) const
{
    if (noise == 0)
        return points;
    return with_copies ? with_noisy_copies(points, noise * spacing, 4, seed)
                       : with_noise(points, noise * spacing, seed);
}

MedialShape medial_torus(int n, std::uint64_t seed)
{
    constexpr double major = 3, minor = 1;
    MedialShape shape;
    shape.name = "torus";
    shape.points = torus(n, major, minor, seed).points;
    shape.spacing = std::sqrt(4 * pi * pi * major * minor / n);
    shape.distance_to_axis = [=](const Point& p) { return std::hypot(p.head<2>().norm() - major, p.z()); };
    for (int k = 0; k < 500; ++k)
        shape.on_axis.emplace_back(major * std::cos(k * pi / 250), major * std::sin(k * pi / 250), 0);
    return shape;
}

MedialShape medial_capsule(int n, std::uint64_t seed)
{
    constexpr double radius = 1, half_length = 2;
    MedialShape shape;
    shape.name = "capsule";
    shape.points = capsule(n, radius, half_length, seed).points;
    shape.spacing = std::sqrt(4 * pi * radius * (half_length + radius) / n);
    shape.distance_to_axis = [=](const Point& p)
    { return (p - Point(0, 0, std::clamp(p.z(), -half_length, half_length))).norm(); };
    for (int k = 0; k <= 200; ++k)
        shape.on_axis.emplace_back(0, 0, half_length * (k / 100.0 - 1));
    return shape;
}

MedialShape medial_box(int n, std::uint64_t seed)
{
    const Vector sides(4, 3, 2);
    MedialShape shape;
    shape.name = "box";
    shape.points = box(n, sides, seed).points;
    shape.spacing = std::sqrt(52.0 / n);
    // A point is on the axis if two faces are equally near: its distances to the two nearest differ by nothing.
    shape.distance_to_axis = [=](const Point& p)
    {
        std::array<double, 6> d;
        for (int k = 0; k < 3; ++k)
        {
            d[2 * k] = sides[k] / 2 - p[k];
            d[2 * k + 1] = sides[k] / 2 + p[k];
        }
        std::sort(d.begin(), d.end());
        return (d[1] - d[0]) / 2;
    };
    // Sheets end at the edges, where two faces meet, and on the flat between the two nearest faces.
    constexpr int steps = 80;
    const Vector half = sides / 2;
    const double inradius = half.minCoeff();
    for (int k = 0; k < 3; ++k)
        for (int depth = 0; depth <= steps; ++depth)
        {
            const double d = inradius * depth / steps, along = half[k] - d;
            for (int t = -2 * steps; t <= 2 * steps; ++t)
                for (const int side : {0, 1, 2, 3})
                {
                    Point p;
                    p[k] = along * t / (2 * steps);
                    p[(k + 1) % 3] = (side & 1 ? 1 : -1) * (half[(k + 1) % 3] - d);
                    p[(k + 2) % 3] = (side & 2 ? 1 : -1) * (half[(k + 2) % 3] - d);
                    shape.on_axis.push_back(p);
                }
        }
    for (int i = -steps; i <= steps; ++i)
        for (int j = -steps; j <= steps; ++j)
            shape.on_axis.emplace_back((half.x() - inradius) * i / steps, (half.y() - inradius) * j / steps, 0);
    return shape;
}

MedialError measure_medial_error(const MedialShape& shape, const Points& centres,
                                 const std::vector<std::array<int, 2>>& edges,
                                 const std::vector<std::array<int, 3>>& triangles)
{
    Points places = centres;
    for (const auto& e : edges)
        places.push_back((centres[e[0]] + centres[e[1]]) / 2);
    for (const auto& t : triangles)
    {
        places.push_back((centres[t[0]] + centres[t[1]] + centres[t[2]]) / 3);
        for (int k = 0; k < 3; ++k)
            places.push_back((centres[t[k]] + centres[t[(k + 1) % 3]]) / 2);
    }
    MedialError error;
    for (const Point& p : places)
        error.strays = std::max(error.strays, shape.distance_to_axis(p) / shape.spacing);
    const NeighbourSearch search(places);
    for (const Point& p : shape.on_axis)
        error.unreached = std::max(error.unreached, (p - places[search.nearest(p)]).norm() / shape.spacing);
    return error;
}

} // namespace shapes
