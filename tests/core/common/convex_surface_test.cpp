// The hull of points that all lie on it: convex_surface.h.
#include <recon/mesh/convex_surface.h>

#include "tests/checks.h"
#include "tests/shapes.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace recon;

namespace
{

constexpr double pi = 3.14159265358979323846;

Points cube(int steps)
{
    Points points;
    for (int i = 0; i <= steps; ++i)
        for (int j = 0; j <= steps; ++j)
            for (int k = 0; k <= steps; ++k)
                if (i % steps == 0 || j % steps == 0 || k % steps == 0)
                    points.push_back(Point(i, j, k) / steps);
    return points;
}

/// Circles of radius 0.5 at these heights.
Points circles(int around, const std::vector<double>& heights)
{
    Points points;
    for (const double z : heights)
        for (int i = 0; i < around; ++i)
            points.emplace_back(0.5 * std::cos(2 * pi * i / around), 0.5 * std::sin(2 * pi * i / around), z);
    return points;
}

} // namespace

TEST(ConvexSurface, GoesThroughAllPoints)
{
    Points cone = circles(30, {0});
    cone.emplace_back(0, 0, 0);
    cone.emplace_back(0, 0, 2);
    const double disc = 15 * 0.25 * std::sin(2 * pi / 30);
    const struct
    {
        Points points;
        double volume;
    } bodies[] = {{cube(1), 1},
                  {cube(4), 1},
                  {circles(30, {0, 3}), 3 * disc},
                  {circles(30, {0, 1, 2, 3}), 3 * disc},
                  {cone, 2 * disc / 3}};
    for (const auto& body : bodies)
    {
        SCOPED_TRACE(body.points.size());
        const auto hull = find_convex_surface(body.points);
        ASSERT_TRUE(hull);
        const checks::MeshReport report = checks::examine_mesh(hull->mesh);
        EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
        EXPECT_NEAR(report.volume, body.volume, 1e-9);
        ASSERT_EQ(hull->mesh.vertices.size(), body.points.size());
        for (std::size_t v = 0; v < body.points.size(); ++v)
            EXPECT_EQ(hull->mesh.vertices[v], body.points[std::size_t(hull->points[v])]);
        ASSERT_EQ(hull->mesh.faux_edges.size(), hull->mesh.triangles.size());
    }
}

TEST(ConvexSurface, DiagonalsOfFlatFacesAreFaux)
{
    const auto hull = find_convex_surface(cube(1));
    ASSERT_TRUE(hull);
    int sides = 0;
    for (std::size_t i = 0; i < hull->mesh.triangles.size(); ++i)
        for (int k = 0; k < 3; ++k)
        {
            const auto& t = hull->mesh.triangles[i];
            const Vector side = hull->mesh.vertices[t[(k + 1) % 3]] - hull->mesh.vertices[t[k]];
            EXPECT_EQ((hull->mesh.faux_edges[i] >> k & 1) != 0, side.norm() > 1.2) << i << " " << k;
            ++sides;
        }
    EXPECT_EQ(sides, 36);
    EXPECT_DOUBLE_EQ(hull->spacing, (3 + 2 * std::sqrt(2.0) + std::sqrt(2.0)) / 6);
}

TEST(ConvexSurface, OthersAreTakenIfTheyAreNoBall)
{
    const auto hull = find_convex_surface(cube(2)); // has a point in the middle of each side
    ASSERT_TRUE(hull);
    EXPECT_TRUE(hull->has_points_within_faces);
    EXPECT_FALSE(find_convex_surface(cube(1))->has_points_within_faces);
    struct Result
    {
        int euler_characteristic;
        bool is_hull;
    };
    const auto choose = [](const std::optional<ConvexSurface>& from, int euler_characteristic)
    {
        return hull_or(
                   from,
                   [&]
                   {
                       if (euler_characteristic == 99)
                           throw AlgorithmFailure("nothing is inside");
                       return Result{euler_characteristic, false};
                   },
                   [](const ConvexSurface&) {
                       return Result{2, true};
                   })
            .is_hull;
    };
    for (const int of_others : {0, -10, 4})
        EXPECT_FALSE(choose(hull, of_others));
    for (const int of_none : {2, 99})
        EXPECT_TRUE(choose(hull, of_none));
    EXPECT_TRUE(choose(find_convex_surface(cube(1)), 0));
    EXPECT_FALSE(choose({}, 2));
    EXPECT_THROW(choose({}, 99), AlgorithmFailure);
}

/// In single precision points within a flat face may lie a little below it.
TEST(ConvexSurface, AllowsForRounding)
{
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(1.1, Vector(1, -2, 3).normalized()));
    for (const double scale : {1.0, 1e-30, 1e30})
    {
        Points points;
        for (const Point& p : cube(6))
            points.push_back(scale * (turn * p).cast<float>().cast<double>());
        const auto hull = find_convex_surface(points);
        ASSERT_TRUE(hull) << scale;
        const checks::MeshReport report = checks::examine_mesh(hull->mesh);
        EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
        EXPECT_NEAR(report.volume / std::pow(scale, 3), 1, 1e-5) << scale;
        EXPECT_GE(hull->mesh.vertices.size(), 8);
    }
}

TEST(ConvexSurface, NoneOfOtherClouds)
{
    Points inside = cube(2), doubled = cube(2), many = shapes::sphere(2'001, 1, 3).points;
    inside.emplace_back(0.5, 0.5, 0.99);
    doubled.insert(doubled.end(), doubled.begin(), doubled.begin() + 5);
    const Points clouds[] = {{}, {{0, 0, 0}}, circles(30, {0}), inside, many, shapes::torus(500, 1, 0.4, 5).points};
    for (std::size_t k = 0; k < std::size(clouds); ++k)
        EXPECT_FALSE(find_convex_surface(clouds[k])) << k;
    EXPECT_TRUE(find_convex_surface(doubled));
    many.pop_back();
    EXPECT_TRUE(find_convex_surface(many));
}
