// Several bodies in one cloud, and what stands on a ground.
#include "filter_noisy_powercrust/reconstruct.h"

#include "tests/checks.h"
#include "tests/ground_scenes.h"
#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <utility>

using namespace recon;

namespace
{

constexpr double pi = 3.14159265358979323846;

TriangleMesh mesh_of_scene(const Points& points, bool opens_holes)
{
    NoisyPowerCrustOptions options;
    options.open_holes = opens_holes;
    return reconstruct_noisy_power_crust(points, options).mesh;
}

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

TEST(NoisyPowerCrust, ABallOverOrBesideAFloorFacesOutward)
{
    checks::expect_ball_apart_from_a_floor_faces_outward(mesh_of_scene);
}

TEST(NoisyPowerCrust, ATableOverAFloorFacesUpAndIsKept)
{
    checks::expect_table_over_a_floor_faces_up(mesh_of_scene);
}

TEST(NoisyPowerCrust, AFloorInFarRingsIsWhole)
{
    checks::expect_floor_in_far_rings_is_whole(mesh_of_scene);
}

TEST(NoisyPowerCrust, WhatStandsOnAGroundFacesOutwardAndTheGroundIsWhole)
{
    checks::expect_ball_faces_outward_on_a_whole_ground(mesh_of_scene);
}

TEST(NoisyPowerCrust, ADepthImageFacesItsCamera)
{
    checks::expect_depth_image_faces_its_camera(mesh_of_scene);
}
