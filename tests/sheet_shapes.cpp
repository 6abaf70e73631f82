#include "shapes.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

/// Open sheets.
namespace shapes
{
namespace
{

using recon::OrientedSamples;
using recon::Point;
using recon::Vector;

constexpr double pi = 3.14159265358979323846;

} // namespace

OrientedSamples sheet(int n, const SheetMap& at, std::uint64_t seed)
{
    constexpr int grid = 64;
    constexpr double step = 1e-5, margin = 1.05;
    const auto across = [&](double u, double v)
    { return Vector((at(u + step, v) - at(u - step, v)).cross(at(u, v + step) - at(u, v - step))); };
    double largest = 0;
    for (int i = 0; i <= grid; ++i)
        for (int j = 0; j <= grid; ++j)
            largest = std::max(largest, margin * across(double(i) / grid, double(j) / grid).norm());
    Random random(seed);
    OrientedSamples samples;
    while (int(samples.points.size()) < n)
    {
        const double u = uniform(random), v = uniform(random), keep = uniform(random);
        const Vector normal = across(u, v);
        if (normal.norm() <= keep * largest)
            continue;
        samples.points.push_back(at(u, v));
        samples.normals.push_back(normal.normalized());
    }
    return samples;
}

Point s_sheet(double u, double v)
{
    const double turn = 1.5 * pi * (2 * u - 1), rise = 1 - std::cos(turn);
    return {0.4 * std::sin(turn), 1.6 * v, 0.4 * (turn > 0 ? rise : -rise)};
}

Point rolled_sheet(double u, double v)
{
    const double turn = 1.5 * pi * (1 + 2 * u);
    return {turn / 12 * std::cos(turn), 1.6 * v, turn / 12 * std::sin(turn)};
}

Point winding_sheet(double u, double v)
{
    const double radius = 0.2 + 0.8 * u, turn = 1.5 * pi * v;
    return {radius * std::cos(turn), radius * std::sin(turn), 0.25 * turn};
}

SheetMap wavy_terrain(double height, double along_x, double along_y)
{
    return [=](double u, double v)
    {
        const double x = 2 * u - 1, y = 2 * v - 1;
        return Point(x, y, height * std::sin(along_x * x) * std::cos(along_y * y));
    };
}

} // namespace shapes
