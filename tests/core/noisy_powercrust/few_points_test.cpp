// Too few points to tell a shape, or just enough.
#include "filter_noisy_powercrust/reconstruct.h"

#include "tests/checks.h"
#include "tests/shapes.h"

#include <recon/errors.h>

#include <gtest/gtest.h>

#include <cmath>
#include <string>

using namespace recon;

TEST(NoisyPowerCrust, OfPointsOnTheirHullIsTheHull)
{
    Points points; // a rod by the circles at its ends
    for (int i = 0; i < 60; ++i)
        for (const double z : {0, 3})
            points.emplace_back(0.5 * std::cos(i * M_PI / 30), 0.5 * std::sin(i * M_PI / 30), z);
    const NoisyPowerCrust crust = reconstruct_noisy_power_crust(points);
    EXPECT_TRUE(crust.is_convex);
    EXPECT_FALSE(crust.denoised);
    EXPECT_EQ(crust.samples, 120);
    EXPECT_EQ(crust.components, 1);
    EXPECT_EQ(crust.genus, 0);
    EXPECT_NEAR(checks::examine_mesh(crust.mesh).volume, 90 * 0.25 * std::sin(M_PI / 30), 1e-9);
    ASSERT_EQ(crust.nearest_sample.size(), crust.mesh.vertices.size());
    EXPECT_EQ(points[std::size_t(crust.nearest_sample[7])], crust.mesh.vertices[7]);
    Points cone; // whose tip looks like an outlier, and whose base has its centre
    for (int i = 0; i < 200; ++i)
        cone.emplace_back(0.5 * std::cos(i * M_PI / 100), 0.5 * std::sin(i * M_PI / 100), 0);
    cone.emplace_back(0, 0, 0);
    cone.emplace_back(0, 0, 1);
    EXPECT_NEAR(checks::examine_mesh(reconstruct_noisy_power_crust(cone).mesh).volume, M_PI / 12, 1e-3);
    Points frustum{{0, 0, 0}, {0, 0, 3}}; // whose crust would bulge
    for (int i = 0; i < 36; ++i)
        for (const int r : {1, 2})
            frustum.emplace_back(r * std::cos(i * M_PI / 18), r * std::sin(i * M_PI / 18), 3 * r - 3);
    EXPECT_NEAR(checks::examine_mesh(reconstruct_noisy_power_crust(frustum).mesh).volume, 126 * std::sin(M_PI / 18),
                1e-9);
    NoisyPowerCrustOptions noisy;
    noisy.noise = 0.05;
    EXPECT_FALSE(reconstruct_noisy_power_crust(shapes::sphere(500, 1, 3).points, noisy).is_convex);
    EXPECT_FALSE(reconstruct_noisy_power_crust(shapes::torus(1'000, 1, 0.4, 3).points).is_convex);
}

TEST(NoisyPowerCrust, FewPointsGiveAResultOrAClearError)
{
    for (int n = 4; n < 40; n += 3)
    {
        SCOPED_TRACE(n);
        try
        {
            const NoisyPowerCrust crust = reconstruct_noisy_power_crust(shapes::sphere(n, 1, std::uint64_t(n)).points);
            EXPECT_TRUE(checks::examine_mesh(crust.mesh).is_closed_oriented_manifold());
        }
        catch (const AlgorithmFailure& e)
        {
            EXPECT_NE(std::string(e.what()).find("ball"), std::string::npos);
        }
    }
}

TEST(NoisyPowerCrust, FewScatteredPointsFaceOutwardOrAreRefused)
{
    int refused = 0;
    for (const int n : {5, 6, 8})
        for (std::uint64_t seed = 80; seed < 130; ++seed)
        {
            SCOPED_TRACE(seed);
            try
            {
                const NoisyPowerCrust crust = reconstruct_noisy_power_crust(shapes::scattered(n, {1, 1, 1}, seed));
                const checks::MeshReport report = checks::examine_mesh(crust.mesh);
                EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
                EXPECT_GT(report.volume, 0);
            }
            catch (const AlgorithmFailure& e)
            {
                refused += std::string(e.what()).find("no volume") != std::string::npos;
            }
        }
    EXPECT_GT(refused, 0);
}
