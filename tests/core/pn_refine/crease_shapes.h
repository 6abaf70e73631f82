#pragma once

#include "filter_pn_refine/refine.h"

#include "tests/shapes.h"

#include <array>
#include <cmath>
#include <map>
#include <vector>

namespace recon
{

inline void append(OrientedSamples& samples, const Point& p, const Vector& normal)
{
    samples.points.push_back(p);
    samples.normals.push_back(normal);
}

/// Positions at which three or more crease points lie.
inline Points corners_of(const PnRefinement& refined)
{
    std::map<std::array<double, 3>, int> count;
    for (int i = 0; i < refined.crease_points; ++i)
    {
        const Point& p = refined.points[std::size_t(i)];
        ++count[{p.x(), p.y(), p.z()}];
    }
    Points corners;
    for (const auto& [p, n] : count)
        if (n > 2)
            corners.emplace_back(p[0], p[1], p[2]);
    return corners;
}

/// A plate of 2 x 2 x `thickness` with a bore along z, `count` samples to the unit of area.
inline OrientedSamples bored_plate(double thickness, double bore, double count, std::uint64_t seed = 7)
{
    OrientedSamples samples;
    shapes::Random random(seed);
    const auto add = [&](double area, const auto& draw)
    {
        for (int i = 0; i < int(area * count); ++i)
        {
            const Eigen::Vector2d place = shapes::draw_pair([&] { return 2 * shapes::uniform(random) - 1; });
            draw(place.x(), place.y());
        }
    };
    const auto put = [&](const Point& p, const Vector& n)
    {
        if (p.head<2>().norm() > bore * (1 - 1e-9))
        {
            append(samples, p, n);
        }
    };
    const double h = thickness / 2;
    for (const double side : {-1.0, 1.0})
    {
        add(4, [&](double u, double v) { put({u, v, side * h}, side * Vector::UnitZ()); });
        add(2 * thickness, [&](double u, double v) { put({side, u, v * h}, side * Vector::UnitX()); });
        add(2 * thickness, [&](double u, double v) { put({u, side, v * h}, side * Vector::UnitY()); });
    }
    add(2 * M_PI * bore * thickness,
        [&](double u, double v)
        {
            const Vector out(std::cos(M_PI * u), std::sin(M_PI * u), 0);
            put(bore * out + v * h * Vector::UnitZ(), -out);
        });
    return samples;
}

/// Samples of what lies above an outline, which runs counter-clockwise around all for which is_inside(x, y).
template <typename IsInside>
OrientedSamples prism(const std::vector<Eigen::Vector2d>& outline, const IsInside& is_inside, double height,
                      double density, std::uint64_t seed)
{
    OrientedSamples samples;
    shapes::Random random(seed);
    Eigen::Vector2d size(0, 0);
    for (const Eigen::Vector2d& p : outline)
        size = size.cwiseMax(p);
    for (int i = 0; i < int(size.prod() * density); ++i)
        for (const double side : {0.0, 1.0})
            if (const double x = size.x() * shapes::uniform(random), y = size.y() * shapes::uniform(random);
                is_inside(x, y))
                append(samples, {x, y, side * height}, (2 * side - 1) * Vector::UnitZ());
    for (std::size_t k = 0; k < outline.size(); ++k)
    {
        const Eigen::Vector2d &from = outline[k], along = outline[(k + 1) % outline.size()] - from,
                              out = Eigen::Vector2d(along.y(), -along.x()).normalized();
        for (int i = 0; i < int(along.norm() * height * density); ++i)
        {
            const Eigen::Vector2d at = from + shapes::uniform(random) * along;
            append(samples, {at.x(), at.y(), height * shapes::uniform(random)}, {out.x(), out.y(), 0});
        }
    }
    return samples;
}

/// An L: at its inner corners, (1, 1, 0) and (1, 1, 1), a face covers three quarters of the plane.
inline const std::vector<Eigen::Vector2d> l_outline = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
constexpr double l_spacing = 0.05;

inline OrientedSamples l_shape(std::uint64_t seed)
{
    const auto is_inside = [](double x, double y) { return x < 1 || y < 1; };
    return prism(l_outline, is_inside, 1, 1 / (l_spacing * l_spacing), seed);
}

} // namespace recon
