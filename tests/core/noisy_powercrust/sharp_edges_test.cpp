#include "filter_noisy_powercrust/edges/sharp_edges.h"

#include "filter_noisy_powercrust/edges/wedge.h"
#include "filter_noisy_powercrust/reconstruct.h"

#include "tests/checks.h"
#include "tests/shapes.h"

#include <recon/mesh/triangle_cuts.h>
#include <recon/search/spatial_order.h>

#include <gtest/gtest.h>

#include <numeric>

using namespace recon;

namespace
{

const Vector sides(2, 1.5, 1);

constexpr double rounding = 0.06;

/// Root mean square distance to the box of the vertices near its edges.
double rms_at_edges(const TriangleMesh& mesh)
{
    Points near;
    for (const Point& p : mesh.vertices)
        if (((sides / 2 - p.cwiseAbs()).array() < rounding).count() > 1)
            near.push_back(p);
    return shapes::rms(near, [](const Point& p) { return shapes::distance_to_box(p, sides); });
}

/// The point of the box with edges rounded to `radius` that is nearest to one on the sharp box.
Point round_off(const Point& p, double radius)
{
    const Point core = p.cwiseMin(sides / 2 - Vector::Constant(radius)).cwiseMax(Vector::Constant(radius) - sides / 2);
    return core + radius * (p - core).normalized();
}

Points in_order(const Points& points)
{
    return points_at(order_spatially(points).order, points);
}

Points noisy_box(std::uint64_t seed)
{
    return in_order(shapes::with_noisy_copies(shapes::box(6000, sides, seed).points, 0.01, 4, seed + 1));
}

/// A crust of the box whose vertices lie on the rounded one.
TriangleMesh rounded_box(double radius)
{
    TriangleMesh mesh = reconstruct_noisy_power_crust(noisy_box(3)).mesh;
    for (Point& p : mesh.vertices)
    {
        const Point on_box = p.cwiseMin(sides / 2).cwiseMax(-sides / 2);
        p = round_off(on_box, radius);
    }
    return mesh;
}

} // namespace

TEST(SharpEdges, SheetsKnowTheirDistanceAndNormal)
{
    Sheet sheet;
    sheet.width = 2;
    sheet.c = {0.1, 0, 0, 0.4, 0, 0.4}; // height 0.1 + 0.1 r^2
    EXPECT_NEAR(sheet.distance(Point(0, 0, 0.6)), 0.5, 1e-12);
    const Point on(3, 1, 1.1);
    const double step = 1e-6;
    EXPECT_NEAR(sheet.distance(on), 0, 1e-12);
    EXPECT_NEAR(sheet.distance(on + step * sheet.normal(on)), step, 1e-9);
}

TEST(SharpEdges, WedgesProjectOntoTheSheetThatBoundsTheSolid)
{
    for (const double side : {1.0, -1.0})
    {
        Wedge wedge;
        wedge.sheets[0].frame = TangentFrame(Vector::UnitZ());
        wedge.sheets[1].frame = TangentFrame(Vector::UnitX());
        wedge.side = side;
        EXPECT_NEAR((wedge.project(Point(-side, 0.5, 0.3)) - Point(-side, 0.5, 0)).norm(), 0, 1e-12);
        EXPECT_NEAR((wedge.project(Point(0.3, 0.5, -side)) - Point(0, 0.5, -side)).norm(), 0, 1e-12);
    }
}

TEST(SharpEdges, RoundedEdgesOfANoisyBoxAreSharpAgain)
{
    const TriangleMesh rounded = rounded_box(rounding);
    const Points points = noisy_box(5);
    TriangleMesh sharp = rounded;
    const int moved = restore_sharp_edges(sharp, points);
    EXPECT_GT(moved, 100);
    const auto report = checks::examine_mesh(sharp);
    EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
    EXPECT_EQ(report.genus(), 0);
    EXPECT_EQ(report.components, 1);
    EXPECT_LT(rms_at_edges(sharp), 0.6 * rms_at_edges(rounded));
    TriangleMesh again = rounded;
    EXPECT_EQ(restore_sharp_edges(again, points, 3), moved);
    EXPECT_EQ(again.vertices, sharp.vertices);
    EXPECT_EQ(again.triangles, sharp.triangles);
}

TEST(SharpEdges, WhatRunsBetweenTheRoundedAndTheSharpEdgeIsNotCut)
{
    const Points points = noisy_box(5);
    TriangleMesh mesh = rounded_box(rounding);
    const auto count_cuts = [&]
    {
        const TriangleCuts cuts(mesh, std::vector<char>(mesh.vertices.size(), 1), 1);
        const std::vector<int> found = cuts.count(mesh.vertices);
        return std::accumulate(found.begin(), found.end(), 0);
    };
    const int before = count_cuts();
    for (double x = -0.7; x <= 0.7; x += 0.2) // needles that touch nothing, with their ends far from the box
    {
        const Point middle(x, sides.y() / 2 - 0.008, sides.z() / 2 - 0.008);
        const Vector way(0, 1, -1), wide(0.003, 0, 0), high(0, 0.003, 0.003);
        const int a = int(mesh.vertices.size()), b = a + 1, c = a + 2, d = a + 3;
        mesh.vertices.insert(mesh.vertices.end(),
                             {middle + way - wide, middle + way + wide, middle - way - high, middle - way + high});
        mesh.triangles.insert(mesh.triangles.end(), {{a, b, c}, {a, c, d}, {a, d, b}, {b, d, c}});
    }
    ASSERT_EQ(count_cuts(), before);
    EXPECT_GT(restore_sharp_edges(mesh, points), 100);
    EXPECT_LE(count_cuts(), before);
}

TEST(SharpEdges, RoundBendsStayRound)
{
    const double radius = 0.2;
    Points points = shapes::box(6000, sides, 3).points;
    for (Point& p : points)
        p = round_off(p, radius);
    points = in_order(shapes::with_noisy_copies(points, 0.01, 4, 7));
    const TriangleMesh before = rounded_box(radius);
    TriangleMesh after = before;
    EXPECT_LT(restore_sharp_edges(after, points), int(before.vertices.size()) / 50);

    const Points torus = in_order(shapes::with_noisy_copies(shapes::torus(5000, 1, 0.35, 2).points, 0.02, 4, 9));
    TriangleMesh ring = reconstruct_noisy_power_crust(torus).mesh;
    EXPECT_EQ(restore_sharp_edges(ring, torus), 0);
}

TEST(SharpEdges, WithoutPointsOrNoiseNothingMoves)
{
    TriangleMesh empty;
    EXPECT_EQ(restore_sharp_edges(empty, {}), 0);
    const TriangleMesh box = rounded_box(rounding);
    TriangleMesh same = box;
    EXPECT_EQ(restore_sharp_edges(same, {}), 0);
    EXPECT_EQ(restore_sharp_edges(same, in_order(box.vertices)), 0);
    EXPECT_EQ(restore_sharp_edges(same, Points(1000, Point::Zero())), 0);
    EXPECT_EQ(same.vertices, box.vertices);
}

TEST(SharpEdges, CrustOfANoisyBoxHasThem)
{
    const NoisyPowerCrust crust = reconstruct_noisy_power_crust(noisy_box(11));
    EXPECT_TRUE(crust.denoised);
    EXPECT_LT(rms_at_edges(crust.mesh), 0.0028); // a quarter of the noise; rounded it is 0.0046
}
