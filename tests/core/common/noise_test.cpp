#include <recon/median.h>
#include <recon/noise/noise.h>

#include <recon/errors.h>

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

using namespace recon;

namespace
{

constexpr double torus_diagonal = 3.7; // of the box around a torus 1 + 0.3, within 1 %

Points noisy_torus(int n, double percent, std::uint64_t seed)
{
    return shapes::with_noise(shapes::torus(n, 1, 0.3, seed).points, percent / 100 * torus_diagonal, seed + 1);
}

/// Of the seeds beyond x = rim, where there is noise, and of the others, which have none: expects that nearly all of
/// the former and none of the latter but beside the rim say so.
void expect_noise_beyond(double rim, double sigma, double most_of_them, const NoiseEstimate& estimate)
{
    int noisy = 0, found = 0, mistaken = 0;
    for (int i = 0; i < estimate.size(); ++i)
    {
        const double x = estimate.seeds()[i].x(), value = estimate.sigma()[i];
        if (x > rim)
        {
            ++noisy;
            found += value > 0.75 * sigma && value < 1.25 * sigma;
        }
        else if (x < rim - 0.1)
            mistaken += value > 0.05 * sigma;
    }
    EXPECT_GT(found, most_of_them * noisy);
    EXPECT_EQ(mistaken, 0);
}

} // namespace

TEST(EstimateNoise, FindsSigmaWithin15Percent)
{
    for (double percent : {0.05, 0.1, 0.2, 0.4, 0.7, 1.0})
    {
        const NoiseEstimate estimate = estimate_noise(noisy_torus(40000, percent, 3));
        EXPECT_NEAR(estimate.median_sigma() / (percent / 100 * torus_diagonal), 1, 0.15) << percent << " %";
    }
}

TEST(EstimateNoise, IsNotRaisedByBends)
{
    // Noise of a fifth of the radius: where the quadric is steep the same noise is taller than it is wide. Five samples
    // a spot.
    const auto ratio = [](const Points& exact)
    {
        const double sigma = 0.01 * bounding_box(exact).diagonal();
        Points noisy = shapes::with_noisy_copies(exact, sigma, 5, 7);
        noisy.erase(noisy.begin(), noisy.begin() + std::ptrdiff_t(exact.size()));
        return estimate_noise(noisy).median_sigma() / sigma;
    };
    EXPECT_NEAR(ratio(shapes::torus(10000, 1, 0.15, 6).points), 1, 0.13);
    EXPECT_NEAR(ratio(shapes::capsule(10000, 0.1, 1, 6).points), 1, 0.15);
    EXPECT_NEAR(ratio(shapes::ellipsoid(10000, Vector(1, 0.3, 0.1), 6).points), 1, 0.13);
}

TEST(EstimateNoise, FindsDensityThroughTheNoise)
{
    const int n = 40000;
    const double area = 4 * M_PI * M_PI * 1 * 0.3;
    for (double percent : {0.0, 0.2, 0.7})
    {
        const double spacing = estimate_noise(noisy_torus(n, percent, 5)).median_spacing();
        EXPECT_NEAR(spacing / std::sqrt(area / n), 1, 0.06) << percent << " %";
    }
}

TEST(EstimateNoise, IsNearlyZeroWithoutNoise)
{
    for (int n : {2000, 20000})
    {
        const NoiseEstimate estimate = estimate_noise(shapes::torus(n, 1, 0.3, 8).points);
        EXPECT_LT(estimate.median_sigma(), 0.1 * estimate.median_spacing()) << n;
    }
}

TEST(EstimateNoise, LeastNoiseIsThatOfTheFaces)
{
    // Few points a side: most places see an edge.
    const Points box = shapes::box(450, Vector(1, 1.5, 2), 5).points;
    EXPECT_GT(estimate_noise(box).median_sigma(), 0.1 * estimate_noise(box).median_spacing());
    EXPECT_LT(estimate_noise(box).least_noise(), 0.02);
    const double spacing = std::sqrt(2 * (1.5 + 2 + 3) / 450);
    EXPECT_GT(estimate_noise(shapes::with_noise(box, 0.2 * spacing, 6)).least_noise(), 0.12);
}

TEST(EstimateNoise, FollowsNoiseThatVaries)
{
    // Half of the sphere is four times as noisy.
    Points points = shapes::sphere(30000, 1, 11).points;
    const Points fine = shapes::with_noise(points, 0.005, 12), coarse = shapes::with_noise(points, 0.02, 13);
    for (std::size_t i = 0; i < points.size(); ++i)
        points[i] = points[i].x() < 0 ? fine[i] : coarse[i];
    const NoiseEstimate estimate = estimate_noise(points);
    EXPECT_NEAR(estimate.sigma_at(Point(-1, 0, 0)), 0.005, 0.001);
    EXPECT_NEAR(estimate.sigma_at(Point(1, 0, 0)), 0.02, 0.004);
    EXPECT_NEAR(estimate.most_sigma(), 0.02, 0.004);
}

TEST(EstimateNoise, SeesANoisyPatch)
{
    // A tenth of a sphere, noisier by far than the region that a seed is compared with.
    constexpr double rim = 0.8;
    for (const double spacings : {0.3, 0.6, 1.0})
    {
        SCOPED_TRACE(spacings);
        const double sigma = spacings * std::sqrt(4 * M_PI / 20000);
        const Points points = shapes::with_noise_beyond(rim, shapes::sphere(20000, 1, 5).points, sigma, 6);
        expect_noise_beyond(rim, sigma, 0.9, estimate_noise(points));
    }
}

TEST(EstimateNoise, SeesANoisyEndOfAnySize)
{
    // Of the region that a seed is compared with, a fifth of all, it is a third to all: where it is half, the median of
    // the region is the noise of neither part. Exact places, of which few settle, do not take the noise of noisy ones.
    const Points points = shapes::ellipsoid(20000, Vector(2, 0.7, 0.5), 7).points;
    std::vector<double> along;
    for (const Point& p : points)
        along.push_back(p.x());
    std::sort(along.rbegin(), along.rend());
    constexpr double sigma = 0.012; // half a spacing
    for (const double share : {0.07, 0.1, 0.12, 0.15, 0.2, 0.5})
    {
        SCOPED_TRACE(share);
        const double rim = along[std::size_t(share * double(points.size()))];
        expect_noise_beyond(rim, sigma, 0.95, estimate_noise(shapes::with_noise_beyond(rim, points, sigma, 8)));
    }
}

TEST(EstimateNoise, DoesNotTakeEdgesForANoisyPatch)
{
    // Of so few samples that many lie at an edge.
    for (const int n : {1500, 4000})
        for (const std::uint64_t seed : {1, 2})
        {
            const NoiseEstimate estimate = estimate_noise(shapes::box(n, Vector(1, 1, 1), seed).points);
            int mistaken = 0;
            for (int i = 0; i < estimate.size(); ++i)
                mistaken += estimate.sigma()[i] * std::sqrt(estimate.density()[i]) > 0.1;
            EXPECT_EQ(mistaken, 0) << n << ", " << seed;
        }
}
// Nearly all seeds lie on a body far away, whose samples are exact and a twentieth as far apart.
TEST(EstimateNoise, IsNotHeldDownByAFinerBodyThatHoldsMostPoints)
{
    constexpr double sigma = 0.03;
    Points points = shapes::with_noise(shapes::sphere(3'000, 1, 3).points, sigma, 5);
    for (const Point& p : shapes::sphere(90'000, 0.3, 7).points)
        points.push_back(p + Point(8, 0, 0));
    const NoiseEstimate noise = estimate_noise(points);
    std::vector<double> of_coarse, of_fine;
    for (int i = 0; i < noise.size(); ++i)
        (noise.seeds()[std::size_t(i)].x() < 4 ? of_coarse : of_fine).push_back(noise.sigma()[std::size_t(i)]);
    EXPECT_NEAR(median(of_coarse), sigma, 0.2 * sigma);
    EXPECT_LT(median(of_fine), 1e-4);
}

TEST(EstimateNoise, IsNotMisledByARodFilledWithNoise)
{
    // The sphere tells the noise; the rod beside it, bent to a ring, is 4 sigma thick.
    const double sigma = 0.01, minor = 2 * sigma, major = 0.6;
    Points points = shapes::sphere(60000, 1, 31).points;
    for (const Point& p : shapes::torus(3000, major, minor, 32).points)
        points.push_back(p + Vector(2, 0, 0));
    const NoiseEstimate estimate = estimate_noise(shapes::with_noise(points, sigma, 33));
    std::vector<double> on_rod;
    for (int i = 0; i < estimate.size(); ++i)
        if (estimate.seeds()[i].x() > 1.2)
            on_rod.push_back(estimate.sigma()[i]);
    ASSERT_GT(on_rod.size(), 20u);
    EXPECT_LT(*std::max_element(on_rod.begin(), on_rod.end()), 1.5 * sigma);
}

TEST(EstimateNoise, TellsThinPlatesFromLayersOfNoise)
{
    struct Case
    {
        double wall, noise, largest;
    };
    // One sample a unit of area. Half of the wall's thickness would be 0.75 and 1.
    for (const Case& one : {Case{1.5, 0, 0.02}, Case{1.5, 0.1, 0.13}, Case{1.5, 0.3, 0.36}, Case{1.5, 0.4, 0.5},
                            Case{2, 0.1, 0.3}, Case{2, 0.3, 0.4}})
    {
        const Points plate = shapes::box(int(5000 + 200 * one.wall), Vector(50, 50, one.wall), 1).points;
        const double sigma = estimate_noise(shapes::with_noise(plate, one.noise, 2)).median_sigma();
        EXPECT_GE(sigma, 0.8 * one.noise) << one.wall << ' ' << one.noise;
        EXPECT_LE(sigma, one.largest) << one.wall << ' ' << one.noise;
    }
}

// Its halves are just as thin as those of two sheets, and half of the places read as two.
TEST(EstimateNoise, IsOfAllOfAnEvenLayer)
{
    const OrientedSamples torus = shapes::torus(20'000, 1, 0.35, 3);
    for (const double sigma : {0.026, 0.039, 0.052}) // 1, 1.5 and 2 spacings
    {
        shapes::Random random(4);
        Points points = torus.points;
        for (std::size_t i = 0; i < points.size(); ++i)
            points[i] += std::sqrt(3.0) * sigma * (2 * shapes::uniform(random) - 1) * torus.normals[i];
        std::vector<double> found = estimate_noise(points).sigma();
        EXPECT_GT(quantile(std::move(found), 0.05), 0.75 * sigma) << sigma;
    }
}

// Noise of bounded reach leaves a gap between them.
TEST(EstimateNoise, IsOfOneSheetOfAPlateWhoseNoiseIsEven)
{
    const OrientedSamples plate = shapes::box(5'300, Vector(50, 50, 1.5), 1);
    constexpr double noise = 0.3;
    shapes::Random random(2);
    Points points = plate.points;
    for (std::size_t i = 0; i < points.size(); ++i)
        points[i] += std::sqrt(3.0) * noise * (2 * shapes::uniform(random) - 1) * plate.normals[i];
    EXPECT_NEAR(estimate_noise(points).median_sigma(), noise, 0.2 * noise);
}

TEST(EstimateNoise, IsOfOneSheetInAStack)
{
    // Without looking for sheets all of it is a slab of noise, 5 and more spacings thick.
    for (const double gap : {1.6, 2.5})
        for (const double noise : {0.0, 0.1, 0.2})
        {
            const Points stack = shapes::stack_of_sheets(16, 30, gap, 3);
            const NoiseEstimate estimate = estimate_noise(shapes::with_noise(stack, noise, 4));
            EXPECT_NEAR(estimate.median_sigma(), noise, 0.02 + 0.1 * noise) << gap << ' ' << noise;
            // At most two sheets count as one, as those of a plate do; a slab has 0.25.
            EXPECT_GT(estimate.median_spacing(), 0.6) << gap << ' ' << noise;
            EXPECT_LT(estimate.median_spacing(), 1.1) << gap << ' ' << noise;
        }
}

// Of noise of ten spacings a neighbourhood that is wider than the noise holds many. Exact samples among noisy copies
// are a sheet with emptier space beside it, but no stack.
TEST(EstimateNoise, IsNotMisledWhereItIsManySpacings)
{
    constexpr double sigma = 0.06;
    const Points exact = shapes::sphere(50'000, 1, 5).points, copies = shapes::with_noisy_copies(exact, sigma, 4, 6);
    for (const Points& cloud : {copies, shapes::with_noise(shapes::sphere(360'000, 1, 5).points, sigma, 6)})
    {
        const NoiseEstimate estimate = estimate_noise(cloud);
        ASSERT_GT(sigma / estimate.median_spacing(), 8);
        std::vector<double> found = estimate.sigma();
        std::sort(found.begin(), found.end());
        EXPECT_GT(found.front(), 0.7 * sigma);
        EXPECT_LT(found.back(), 1.4 * sigma);
    }
}

TEST(EstimateNoise, FollowsDensityThatVaries)
{
    // Of the half x > 0 one point in ten.
    Points points;
    const Points all = shapes::sphere(60000, 1, 14).points;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (all[i].x() < 0 || i % 10 == 0)
            points.push_back(all[i]);
    const NoiseEstimate estimate = estimate_noise(points);
    EXPECT_NEAR(estimate.spacing_at(Point(1, 0, 0)) / estimate.spacing_at(Point(-1, 0, 0)), std::sqrt(10), 0.3);
}

TEST(EstimateNoise, IsNotMovedByOutliersOrDuplicates)
{
    Points points = noisy_torus(20000, 0.3, 17);
    const double before = estimate_noise(points).median_sigma();
    for (const Point& p : shapes::scattered(1000, {3, 3, 3}, 18))
        points.push_back(p);
    EXPECT_NEAR(estimate_noise(points).median_sigma() / before, 1, 0.05);

    Points twice = points;
    twice.insert(twice.end(), points.begin(), points.end());
    EXPECT_EQ(estimate_noise(twice).median_sigma(), estimate_noise(points).median_sigma());
}

TEST(EstimateNoise, DoesNotDependOnOrderOrThreads)
{
    Points points = noisy_torus(5000, 0.3, 21);
    NoiseOptions options;
    options.threads = 1;
    const NoiseEstimate one = estimate_noise(points, options);
    std::reverse(points.begin(), points.end());
    options.threads = 3;
    const NoiseEstimate three = estimate_noise(points, options);
    EXPECT_EQ(one.sigma(), three.sigma());
    EXPECT_EQ(one.density(), three.density());
}

TEST(EstimateNoise, ScalesWithTheCloud)
{
    const Points points = noisy_torus(5000, 0.3, 23);
    const NoiseEstimate unit = estimate_noise(points);
    for (double scale : {1e-30, 1e30})
    {
        Points scaled = points;
        for (Point& p : scaled)
            p *= scale;
        const NoiseEstimate estimate = estimate_noise(scaled);
        EXPECT_NEAR(estimate.median_sigma() / scale / unit.median_sigma(), 1, 1e-6);
        EXPECT_NEAR(estimate.median_spacing() / scale / unit.median_spacing(), 1, 1e-6);
    }
    Points moved = points;
    for (Point& p : moved)
        p += Vector(1e6, -5e6, 3e6);
    EXPECT_NEAR(estimate_noise(moved).median_sigma() / unit.median_sigma(), 1, 1e-3);
}

TEST(EstimateNoise, SurvivesHostileClouds)
{
    const auto check = [](const Points& points, const char* what)
    {
        const NoiseEstimate estimate = estimate_noise(points);
        ASSERT_GT(estimate.size(), 0) << what;
        for (int i = 0; i < estimate.size(); ++i)
        {
            EXPECT_TRUE(std::isfinite(estimate.sigma()[i]) && estimate.sigma()[i] >= 0) << what;
            EXPECT_TRUE(std::isfinite(estimate.density()[i]) && estimate.density()[i] > 0) << what;
        }
        EXPECT_GE(estimate.nearest_seed(Point(1e9, 0, 0)), 0) << what;
    };
    check({Point(1, 2, 3)}, "one point");
    check(Points(50, Point(1, 2, 3)), "equal points");
    for (int n : {2, 3, 5, 12, 40})
        check(shapes::sphere(n, 1, 4).points, "few points");
    Points line, grid;
    for (int i = 0; i < 200; ++i)
        line.emplace_back(i, 2 * i, 0);
    check(line, "line");
    for (int i = 0; i < 900; ++i)
        grid.emplace_back(i % 30, i / 30, 0);
    check(grid, "grid");
    EXPECT_NEAR(estimate_noise(grid).median_sigma(), 0, 1e-6);
    Points far = shapes::sphere(500, 1, 5).points;
    far.emplace_back(1e9, 0, 0);
    check(far, "far outlier");

    EXPECT_THROW(estimate_noise({}), InvalidInput);
    EXPECT_THROW(estimate_noise({Point(0, std::numeric_limits<double>::quiet_NaN(), 0)}), InvalidInput);
    NoiseOptions options;
    options.seeds = -1;
    EXPECT_THROW(estimate_noise(grid, options), InvalidInput);
    EXPECT_THROW(estimate_noise(grid, {}, Progress([](double, const std::string&) { return false; })), Cancelled);
}
