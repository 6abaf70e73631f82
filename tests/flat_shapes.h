#pragma once

// Shapes with flat faces, sampled along their edges only.
#include "tests/checks.h"

#include <recon/geometry.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace flat_shapes
{

inline constexpr double pi = 3.14159265358979323846;

inline void append_ring(recon::Points& points, double x, double y, double z, double radius, int count)
{
    for (int k = 0; k < count; ++k)
    {
        const double angle = 2 * pi * k / count;
        points.emplace_back(x + radius * std::cos(angle), y + radius * std::sin(angle), z);
    }
}

inline constexpr double outer = 0.45, hub = 0.2, bore = 0.03, thickness = 0.06;
inline constexpr int bores = 4;

/// A washer with bores, sampled on its rims only, as a CAD program writes it.
inline recon::Points flange()
{
    recon::Points points;
    for (const double z : {0.0, thickness})
    {
        append_ring(points, 0, 0, z, outer, 150);
        append_ring(points, 0, 0, z, hub, 70);
        for (int k = 0; k < bores; ++k)
            append_ring(points, 0.33 * std::cos(pi / 2 * k), 0.33 * std::sin(pi / 2 * k), z, bore, 18);
    }
    return points;
}

inline constexpr int plate_bores = 9;

/// A plate with bores, whose four edges and bores have as many pieces each.
inline recon::Points bored_plate(int pieces)
{
    recon::Points points;
    const auto add = [&](double x, double y)
    {
        for (const double z : {0.0, 0.5})
            points.emplace_back(x, y, z);
    };
    for (int k = 0; k < pieces; ++k)
    {
        const double along = 4.0 * k / pieces, angle = 2 * pi * k / pieces;
        add(along, 0);
        add(4, along);
        add(4 - along, 4);
        add(0, 4 - along);
        for (int bore = 0; bore < plate_bores; ++bore)
            add(0.8 + 1.2 * (bore / 3) + 0.4 * std::cos(angle), 0.8 + 1.2 * (bore % 3) + 0.4 * std::sin(angle));
    }
    return points;
}

/// One closed surface.
inline void expect_solid(const recon::TriangleMesh& mesh, int genus, double volume)
{
    const checks::MeshReport report = checks::examine_mesh(mesh);
    EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.genus(), genus);
    EXPECT_NEAR(report.volume / volume, 1, 0.03);
}

/// With all holes of the flange and its volume.
inline void expect_bored_flange(const recon::TriangleMesh& mesh)
{
    expect_solid(mesh, 1 + bores, pi * (outer * outer - hub * hub - bores * bore * bore) * thickness);
}

/// Circles around the z axis or parallel to it.
struct Ring
{
    double z, radius;
};

inline constexpr int counterbores = 3;
inline constexpr double counterbore_at = 0.3;
inline const std::vector<Ring> coupling_outside = {{0, 0.44}, {0.01, 0.45}, {0.24, 0.45}, {0.25, 0.44}};
inline const std::vector<Ring> coupling_bore = {{0, 0.1}, {0.25, 0.1}};
/// With a fillet at its ground.
inline const std::vector<Ring> coupling_counterbore = {{0, 0.03},     {0.12, 0.03}, {0.12, 0.054}, {0.1212, 0.0582},
                                                       {0.126, 0.06}, {0.24, 0.06}, {0.25, 0.07}};

/// A disc with chamfers, a bore and counterbores, sampled on its rims only.
inline recon::Points coupling()
{
    recon::Points points;
    for (const auto& [z, radius] : coupling_outside)
        append_ring(points, 0, 0, z, radius, 80);
    for (const auto& [z, radius] : coupling_bore)
        append_ring(points, 0, 0, z, radius, 30);
    for (int k = 0; k < counterbores; ++k)
        for (const auto& [z, radius] : coupling_counterbore)
            append_ring(points, counterbore_at * std::cos(2 * pi / counterbores * k),
                        counterbore_at * std::sin(2 * pi / counterbores * k), z, radius, 24);
    return points;
}

/// Of what the rings' profile encloses with the axis.
inline double lathed_volume(const std::vector<Ring>& rings)
{
    double volume = 0;
    for (std::size_t i = 1; i < rings.size(); ++i)
    {
        const double a = rings[i - 1].radius, b = rings[i].radius;
        volume += pi / 3 * (rings[i].z - rings[i - 1].z) * (a * a + a * b + b * b);
    }
    return volume;
}

/// With all holes of the coupling and its volume.
inline void expect_bored_coupling(const recon::TriangleMesh& mesh)
{
    expect_solid(mesh, 1 + counterbores,
                 lathed_volume(coupling_outside) - lathed_volume(coupling_bore) -
                     counterbores * lathed_volume(coupling_counterbore));
}

inline double distance_to_segment(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b)
{
    const double along = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
    return (p - a - along * (b - a)).norm();
}

/// Distance to the profile in the half plane through the axis.
inline double distance_to_profile(const std::vector<Ring>& rings, double z, double radius)
{
    const Eigen::Vector2d p(z, radius);
    double least = 1e300;
    for (std::size_t i = 1; i < rings.size(); ++i)
    {
        const Eigen::Vector2d a(rings[i - 1].z, rings[i - 1].radius), b(rings[i].z, rings[i].radius);
        least = std::min(least, distance_to_segment(p, a, b));
    }
    return least;
}

/// A prism sampled along its edges only.
inline recon::Points prism(const std::vector<Eigen::Vector2d>& polygon, double height, double spacing)
{
    recon::Points points;
    const auto append_edge = [&](const recon::Point& from, const recon::Point& to)
    {
        const int count = std::max(1, int(std::lround((to - from).norm() / spacing)));
        for (int k = 0; k < count; ++k)
            points.push_back(from + (to - from) * (double(k) / count));
    };
    for (std::size_t i = 0; i < polygon.size(); ++i)
    {
        const Eigen::Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        append_edge(recon::Point(a.x(), a.y(), 0), recon::Point(b.x(), b.y(), 0));
        append_edge(recon::Point(b.x(), b.y(), height), recon::Point(a.x(), a.y(), height));
        append_edge(recon::Point(a.x(), a.y(), 0), recon::Point(a.x(), a.y(), height));
    }
    return points;
}

inline bool is_ground(const recon::Point& p)
{
    const double r = std::hypot(p.x(), p.y());
    bool result = r < outer && r > hub;
    for (int k = 0; k < bores; ++k)
        result = result &&
                 std::hypot(p.x() - 0.33 * std::cos(pi / 2 * k), p.y() - 0.33 * std::sin(pi / 2 * k)) > 0.98 * bore;
    return result;
}

inline const recon::Vector rounded_core(0.35, 0.25, 0.15); ///< Half sides of the box between the rounding's axes.
inline constexpr double rounding = 0.05;

/// The eight corners of a box with round edges, as a CAD program writes it: neither faces nor the rounded edges between
/// corners carry samples.
inline recon::OrientedSamples rounded_corners()
{
    constexpr int pieces = 10;
    recon::OrientedSamples result;
    for (int octant = 0; octant < 8; ++octant)
        for (int i = 0; i <= pieces; ++i)
            for (int k = 0; k <= (i == pieces ? 0 : pieces); ++k)
            {
                const double up = pi / 2 * i / pieces, around = pi / 2 * k / pieces;
                recon::Vector normal(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around), std::sin(up));
                recon::Vector corner = rounded_core;
                for (int axis = 0; axis < 3; ++axis)
                    if (octant >> axis & 1)
                    {
                        normal[axis] = -normal[axis];
                        corner[axis] = -corner[axis];
                    }
                result.points.push_back(corner + rounding * normal);
                result.normals.push_back(normal);
            }
    return result;
}

inline double rounded_volume()
{
    const double a = 2 * rounded_core[0], b = 2 * rounded_core[1], c = 2 * rounded_core[2], r = rounding;
    return a * b * c + 2 * r * (a * b + b * c + c * a) + pi * r * r * (a + b + c) + 4 * pi / 3 * r * r * r;
}

/// Signed, negative within.
inline double distance_to_rounded_box(const recon::Point& p)
{
    const recon::Vector beyond = p.cwiseAbs() - rounded_core;
    return beyond.cwiseMax(0).norm() + std::min(beyond.maxCoeff(), 0.0) - rounding;
}

} // namespace flat_shapes
