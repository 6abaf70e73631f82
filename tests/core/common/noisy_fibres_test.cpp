#include <recon/noise/noisy_fibres.h>

#include <recon/noise/cleanness.h>
#include <recon/noise/noise.h>
#include <recon/search/spatial_order.h>

#include "tests/scans.h"
#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>
#include <utility>

using namespace recon;

namespace
{

constexpr double major = 1, minor = 0.4;
constexpr int positions = 4'000; // 0.05 apart

Points sorted(const Points& points)
{
    return points_at(order_spatially(points, 1).order, points);
}

bool has_fibres(const Points& points)
{
    const Points ordered = sorted(points);
    return has_noisy_fibres(ordered, BlockSearch(ordered), 1);
}

/// Copies of each sample of a torus, moved along its normal and, by that share of it, to any side.
Points moved_along_normals(int copies, double sigma, std::uint64_t seed, double sideways = 0)
{
    const OrientedSamples torus = shapes::torus(positions, major, minor, seed);
    return shapes::with_noise(shapes::copies_along_normals(torus, sigma, copies, seed + 1).points, sideways * sigma,
                              seed + 2);
}

/// Square rods beside each other, points at `heights` on each of their edges. \param shift of an edge's points along
/// it, at most.
Points rods(const std::vector<double>& heights, double shift)
{
    shapes::Random random(11);
    Points points;
    for (int i = 0; i < 20; ++i)
        for (int j = 0; j < 20; ++j)
        {
            const double left = i + 0.4 * shapes::uniform(random), front = j + 0.4 * shapes::uniform(random);
            for (const double x : {0.0, 0.5})
                for (const double y : {0.0, 0.6})
                {
                    const double lowest = shift * shapes::uniform(random);
                    for (const double z : heights)
                        points.emplace_back(left + x, front + y, lowest + z);
                }
        }
    return points;
}

TEST(NoisyFibres, AreCopiesAlongTheNormal)
{
    for (const int copies : {4, 10, 30})
        for (const double sigma : {0.01, 0.04})
            EXPECT_TRUE(has_fibres(moved_along_normals(copies, sigma, 3))) << copies << ' ' << sigma;
}

TEST(NoisyFibres, NeedNotBeExact)
{
    for (const auto& [sigma, sideways] : {std::pair(0.03, 0.05), std::pair(0.03, 0.1), std::pair(0.05, 0.05)})
    {
        const Points points = moved_along_normals(5, sigma, 3, sideways);
        EXPECT_TRUE(has_fibres(points)) << sigma << ' ' << sideways;
        EXPECT_NEAR(estimate_noise(points).median_sigma(), sigma, 0.2 * sigma) << sigma << ' ' << sideways;
    }
}

TEST(NoisyFibres, AreFramesOfACameraThatStandsStill)
{
    OrientedSamples seen = shapes::laser_scan(120, 0, true, 3);
    for (std::size_t i = 0; i < seen.points.size(); ++i)
        seen.normals[i] = seen.points[i].normalized(); // the rays
    for (const int frames : {5, 20})
        EXPECT_TRUE(has_fibres(shapes::copies_along_normals(seen, 0.02, frames, 4).points)) << frames;
}

TEST(NoisyFibres, AreNoneWhereNoiseGoesAnywhereOrThereIsNone)
{
    EXPECT_FALSE(has_fibres(shapes::scattered(2'000, Vector(1, 0, 0), 5)));
    const Points torus = shapes::torus(positions, major, minor, 5).points;
    EXPECT_FALSE(has_fibres(torus));
    EXPECT_FALSE(has_fibres(shapes::torus_of_rings(20, 8).points));
    EXPECT_FALSE(has_fibres(shapes::laser_scan(240, 0.01, true, 3).points));
    EXPECT_FALSE(has_fibres(shapes::scan_by_beams(720, 12, 0.01, 3).points));
    for (const double sigma : {0.01, 0.04})
        EXPECT_FALSE(has_fibres(shapes::with_noisy_copies(torus, sigma, 4, 6))) << sigma;
}

// Copies in line by chance, in up to 0.9 of the places, were told as fibres, and the tubes as noise of 0.8 spacings.
TEST(NoisyFibres, AreNoCopiesInLineByChance)
{
    for (const double diameter : {1.5, 2.0, 2.5})
        EXPECT_FALSE(
            has_fibres(shapes::with_noisy_copies(shapes::torus_of_rings(22, diameter / 2).points, 0.1, 4, 161)))
            << diameter;
    EXPECT_FALSE(has_fibres(shapes::with_noisy_copies(shapes::bored_plate(3, 2, 62), 0.1, 4, 162)));
}

TEST(NoisyFibres, AreNoneIfFewPlacesSeeThem)
{
    Points points = moved_along_normals(4, 0.01, 3);
    for (const Point& p : shapes::torus(3 * int(points.size()), 3, 1, 5).points)
        points.push_back(p + Vector(20, 0, 0));
    EXPECT_FALSE(has_fibres(points));
}

TEST(NoisyFibres, AreNoRowsInOneSurface)
{
    shapes::Random random(13);
    Points points;
    for (int row = 0; row < 60; ++row)
        for (int i = 0; i < 60; ++i)
            points.emplace_back(60 * shapes::uniform(random), row, 0);
    EXPECT_FALSE(has_fibres(points));
}

// Points of an edge are as far apart as those of the next, or begin where those do.
TEST(NoisyFibres, AreNoEdgesOfRods)
{
    EXPECT_FALSE(has_fibres(rods({0, 0.3, 0.6, 0.9, 1.2}, 0.3)));
    EXPECT_FALSE(has_fibres(rods({0, 0.1, 0.5, 1.1, 1.2}, 0)));
}

// A few fibres are on a quadric through them, so the noise of copies along normals was told as 0.
TEST(NoisyFibres, TellTheirNoise)
{
    for (const int copies : {4, 10, 30})
        for (const double sigma : {0.01, 0.04})
        {
            const Points points = sorted(moved_along_normals(copies, sigma, 7));
            const NoiseEstimate found = estimate_noise(points);
            EXPECT_NEAR(found.median_sigma(), sigma, 0.2 * sigma) << copies << ' ' << sigma;
            EXPECT_TRUE(measure_cleanness(points, 1).is_noisy_in_parts()) << copies << ' ' << sigma;
        }
}

// Or thirty frames would look as if a surface were known far better between the pixels.
TEST(NoisyFibres, CountAsFewPoints)
{
    const double apart = std::sqrt(4 * M_PI * M_PI * major * minor / positions);
    // Of little noise, where a window must reach several fibres, and of more.
    for (const auto& [sigma, least, most] : {std::tuple(0.01, 0.6, 1.0), std::tuple(0.04, 0.35, 0.6)})
    {
        const NoiseEstimate found = estimate_noise(moved_along_normals(30, sigma, 9));
        EXPECT_GT(found.median_spacing(), least * apart) << sigma;
        EXPECT_LT(found.median_spacing(), most * apart) << sigma;
    }
}

} // namespace
