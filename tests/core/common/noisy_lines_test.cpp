#include <recon/noise/noisy_lines.h>

#include <recon/noise/cleanness.h>
#include <recon/noise/noise.h>
#include <recon/search/spatial_order.h>

#include "tests/scans.h"
#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace recon;

namespace
{

Points sorted(const Points& points)
{
    return points_at(order_spatially(points, 1).order, points);
}

bool has_lines(const Points& points)
{
    const Points ordered = sorted(points);
    return has_noisy_lines(ordered, BlockSearch(ordered), 1);
}

/// Rings about the axis of a torus of radii 1 and 0.4, `apart` from each other, points `along` from each other.
Points rings(double apart, double along)
{
    Points points;
    for (double a = 0; a < 2 * M_PI; a += apart / 0.4)
    {
        const double radius = 1 + 0.4 * std::cos(a);
        for (double b = 0; b < 2 * M_PI; b += along / radius)
            points.emplace_back(radius * std::cos(b), radius * std::sin(b), 0.4 * std::sin(a));
    }
    return points;
}

/// Edges of stairs, two on each tread, whose points are as far apart as these.
Points edges_of_stairs()
{
    constexpr double along = 0.01, deep = 0.01, high = 0.05;
    Points points;
    for (int step = 0; step < 40; ++step)
        for (const double edge : {0.0, deep})
            for (int i = 0; i < 100; ++i)
                points.emplace_back(along * i, deep * step + edge, high * step);
    return points;
}

TEST(NoisyLines, AreReadingsOfFewBeams)
{
    for (const int stride : {8, 12, 20})
        for (const double noise : {0.005, 0.02})
            EXPECT_TRUE(has_lines(shapes::scan_by_beams(720, stride, noise, 3).points)) << stride << " " << noise;
}

TEST(NoisyLines, AreNoneWithoutNoiseOrWhereItGoesAnywhere)
{
    EXPECT_FALSE(has_lines(shapes::scan_by_beams(720, 12, 0, 3).points));
    EXPECT_FALSE(has_lines(shapes::laser_scan(240, 0.01, true, 3).points));
    for (const double noise : {0.0, 0.002, 0.01})
    {
        EXPECT_FALSE(has_lines(shapes::with_noise(rings(0.1, 0.01), noise, 5))) << noise;
        EXPECT_FALSE(has_lines(shapes::with_noise(shapes::torus(20'000, 1, 0.4, 5).points, noise, 5))) << noise;
    }
}

// Points on both edges of a tread stray in its plane as noise does, but to two places only.
TEST(NoisyLines, AreNoEdgesOfNarrowFaces)
{
    EXPECT_FALSE(has_lines(edges_of_stairs()));
}

TEST(NoisyLines, ReachOverTheNext)
{
    const int around = 720, stride = 12;
    const double angle = 2 * M_PI * stride / around; // between beams
    const Points points = sorted(shapes::scan_by_beams(around, stride, 0.005, 3).points);
    const std::vector<double> reach = find_noisy_lines(points, BlockSearch(points), points, 2);
    ASSERT_EQ(reach.size(), points.size());
    int found = 0, wide = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (reach[i] > 0)
        {
            ++found;
            wide += reach[i] > 0.9 * angle * points[i].norm();
        }
    EXPECT_GT(found, 0.8 * double(points.size()));
    EXPECT_GT(wide, 0.95 * found);
}

// None was found in them before, and they looked exact.
TEST(NoisyLines, TellTheirNoise)
{
    for (const double noise : {0.005, 0.02})
    {
        const Points points = sorted(shapes::scan_by_beams(720, 12, noise, 3).points);
        const double found = estimate_noise(points).median_sigma(); // across surfaces that are seen at a slant
        EXPECT_GT(found, 0.5 * noise);
        EXPECT_LT(found, noise);
        EXPECT_TRUE(measure_cleanness(points, 1).is_noisy_in_parts());
    }
}

} // namespace
