#include "filter_noisy_powercrust/reconstruct.h"

#include "tests/checks.h"
#include "tests/shapes.h"

#include <gtest/gtest.h>

using namespace recon;

namespace
{

constexpr double pi = 3.14159265358979323846;

} // namespace

TEST(NoisyPowerCrust, ClosesAHoleOfTheScanAndTrimsItWhenAsked)
{
    const Points points = shapes::sphere_below(0.7, 6000, 1, 5);
    const NoisyPowerCrust closed = reconstruct_noisy_power_crust(points);
    EXPECT_EQ(closed.genus, 0);
    EXPECT_EQ(closed.boundary_loops, 0);
    EXPECT_GT(checks::examine_mesh(closed.mesh).volume, 0.9 * 4 * pi / 3);
    NoisyPowerCrustOptions options;
    options.trim_length = 0.15;
    const NoisyPowerCrust open = reconstruct_noisy_power_crust(points, options);
    EXPECT_EQ(open.boundary_loops, 1);
    EXPECT_EQ(open.genus, 0);
    EXPECT_FALSE(checks::examine_mesh(open.mesh).closed);
    EXPECT_TRUE(checks::examine_mesh(open.mesh).consistently_oriented);
}

TEST(NoisyPowerCrust, OpensAHoleOfTheScanWhenAsked)
{
    const Points points = shapes::sphere_below(0.7, 6000, 1, 5);
    NoisyPowerCrustOptions options;
    options.open_holes = true;
    for (const double sigma : {0.0, 0.01})
    {
        const Points cloud = sigma > 0 ? shapes::with_noisy_copies(points, sigma, 3, 4) : points;
        const NoisyPowerCrust open = reconstruct_noisy_power_crust(cloud, options);
        EXPECT_EQ(open.denoised, sigma > 0);
        EXPECT_EQ(open.boundary_loops, 1);
        EXPECT_EQ(open.components, 1);
        EXPECT_EQ(open.genus, 0);
        EXPECT_EQ(open.nearest_sample.size(), open.mesh.vertices.size());
        for (const Point& v : open.mesh.vertices)
            EXPECT_LT(v.z(), 0.8);
    }
}

TEST(NoisyPowerCrust, WhatClosesANoisyCupWithAWavyRimIsDrawnTaut)
{
    const double height = 1.2;
    const Points cup = shapes::cup_with_wavy_rim(6000, height, 0.05, 10);
    NoisyPowerCrustOptions loose;
    loose.smooth = false;
    for (const double sigma : {0.0, 0.01})
    {
        const Points cloud = sigma > 0 ? shapes::with_noisy_copies(cup, sigma, 4, 5) : cup;
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(cloud);
        const checks::MeshReport report = checks::examine_mesh(crust.mesh);
        EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
        EXPECT_EQ(report.genus(), 0);
        EXPECT_NEAR(report.volume / (pi * height), 1, 0.012);
        EXPECT_GT(checks::examine_mesh(reconstruct_noisy_power_crust(cloud, loose).mesh).volume / (pi * height), 1.015);
    }
}
