// Several bodies in one cloud, and what stands on a ground.
#include "filter_noisy_powercrust/reconstruct.h"

#include "tests/checks.h"
#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <utility>

using namespace recon;

namespace
{

constexpr double pi = 3.14159265358979323846;

} // namespace

TEST(NoisyPowerCrust, KeepsBothBodiesOfAScene)
{
    Points points = shapes::sphere(3000, 1, 5).points;
    for (const Point& p : shapes::sphere(1500, 0.5, 6).points)
        points.push_back(p + Point(4, 0, 0));
    NoisyPowerCrustOptions options;
    const NoisyPowerCrust both = reconstruct_noisy_power_crust(points, options);
    EXPECT_EQ(both.components, 2);
    EXPECT_TRUE(both.warnings.empty());
    EXPECT_NEAR(checks::examine_mesh(both.mesh).volume, 4 * pi / 3 * 1.125, 0.1);
    options.keep_components = KeepComponents::largest;
    const NoisyPowerCrust larger = reconstruct_noisy_power_crust(points, options);
    EXPECT_EQ(larger.components, 1);
    ASSERT_EQ(larger.warnings.size(), 1u);
    EXPECT_NE(larger.warnings[0].find("1 other body was left out, with 12 %"), std::string::npos) << larger.warnings[0];
}

TEST(NoisyPowerCrust, KeepsAFullBodyOfFewSamples)
{
    Points points = shapes::sphere(20000, 1, 5).points;
    for (const Point& p : shapes::sphere(400, 0.14, 6).points) // a fiftieth of the samples
        points.push_back(p + Point(2, 0, 0));
    EXPECT_EQ(reconstruct_noisy_power_crust(points).components, 2);
}

TEST(NoisyPowerCrust, KeepsASmallBodyOfManySamples)
{
    Points points = shapes::sphere(3000, 1, 5).points;
    for (const Point& p : shapes::sphere(120, 0.12, 6).points)
        points.push_back(p + Point(4, 0, 0));
    const NoisyPowerCrust crust = reconstruct_noisy_power_crust(points);
    EXPECT_EQ(crust.components, 2);
    EXPECT_TRUE(crust.warnings.empty());
}

TEST(NoisyPowerCrust, SaysThatASmallBodyOfManySamplesWasLeftOut)
{
    for (const auto& [samples, said] : {std::pair{15, 0u}, std::pair{45, 1u}})
    {
        Points points = shapes::sphere(1200, 1, 5).points;
        for (const Point& p : shapes::sphere(samples, 0.12, 6).points)
            points.push_back(p + Point(4, 0, 0));
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(points);
        EXPECT_EQ(crust.components, 1);
        EXPECT_EQ(crust.warnings.size(), said);
    }
}

TEST(NoisyPowerCrust, KeepsStrayShellsOnlyWhenAsked)
{
    Points points = shapes::sphere(3000, 1, 5).points;
    for (const Point& p : shapes::sphere(60, 0.5, 6).points)
        points.push_back(p + Point(4, 0, 0));
    NoisyPowerCrustOptions options;
    EXPECT_EQ(reconstruct_noisy_power_crust(points, options).components, 1);
    options.keep_components = KeepComponents::all;
    EXPECT_EQ(reconstruct_noisy_power_crust(points, options).components, 2);
}

TEST(NoisyPowerCrust, AnExactCavityStays)
{
    // All inner poles of an exact sphere coincide: one visible ball stands for the whole cavity.
    Points points = shapes::sphere(6000, 1, 1).points;
    const Points cavity = shapes::sphere(3000, 0.5, 2).points;
    points.insert(points.end(), cavity.begin(), cavity.end());
    const checks::MeshReport report = checks::examine_mesh(reconstruct_noisy_power_crust(points).mesh);
    EXPECT_EQ(report.components, 2);
    EXPECT_NEAR(report.volume, 4 * pi / 3 * (1 - 0.125), 0.02);
}

// Seen from above, so that only its top is there, without legs, and its shadow on the floor.
TEST(NoisyPowerCrust, ATableOverAFloorFacesUpAndIsKept)
{
    const OrientedSamples scene = shapes::table_over_a_floor(4);
    NoisyPowerCrustOptions options;
    options.open_holes = true;
    const NoisyPowerCrust crust = reconstruct_noisy_power_crust(shapes::with_noise(scene.points, 0.2, 5), options);
    EXPECT_GT(checks::share_faced(crust.mesh, scene, 3), 0.97);
}

TEST(NoisyPowerCrust, WhatStandsOnAGroundFacesOutwardAndTheGroundIsWhole)
{
    const Points level = shapes::with_noise(shapes::ball_on_a_ground(4), 0.2, 5);
    // Whichever axis is up.
    for (const int up : {2, 1})
    {
        Points points = level;
        if (up == 1)
            for (Point& p : points)
                p = Point(p.x(), p.z(), -p.y());
        for (const bool is_opened : {false, true})
        {
            NoisyPowerCrustOptions options;
            options.open_holes = is_opened;
            TriangleMesh mesh = reconstruct_noisy_power_crust(points, options).mesh;
            const checks::MeshReport report = checks::examine_mesh(mesh);
            EXPECT_EQ(report.components, 1);
            EXPECT_EQ(report.is_closed_oriented_manifold(), !is_opened) << report.text();
            if (up == 1)
                for (Point& p : mesh.vertices)
                    p = Point(p.x(), -p.z(), p.y());
            const checks::SceneReport scene = checks::examine_ball_on_a_ground(mesh);
            EXPECT_GT(scene.ball, 0.9) << up << is_opened;
            EXPECT_GT(scene.ground, 0.9) << up << is_opened;
        }
    }
}
