#include "filter_amls/fits/local_scales.h"

#include "tests/shapes.h"

#include <recon/noise/noise.h>
#include <recon/search/spatial_order.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace recon;

namespace
{

struct Widths
{
    Points seeds;
    std::vector<double> widths;
};

Widths choose(const Points& points)
{
    Points sorted;
    for (const int i : order_spatially(points).order)
        sorted.push_back(points[i]);
    const NoiseEstimate noise = estimate_noise(sorted, {});
    const BlockSearch search(sorted);
    const LocalScales scales = choose_widths(sorted, search, noise, 1, {});
    Widths result{noise.seeds(), {}};
    for (const LocalScale& scale : scales.at_seed)
        result.widths.push_back(scale.width);
    return result;
}

double median(std::vector<double> values)
{
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
    return values[values.size() / 2];
}

} // namespace

TEST(LocalScales, WidthsFollowTheCurvature)
{
    // Two spheres of the same density: with the risks of too few seeds pooled to tell bias from noise, or of all of
    // them, the widths would be alike.
    double mean = 0;
    for (const unsigned seed : {1u, 2u, 3u, 4u})
    {
        Points points = shapes::sphere(20000, 1, seed).points;
        for (const Point& p : shapes::sphere(1250, 0.25, seed).points)
            points.push_back(p + Point(3, 0, 0));
        const Widths found = choose(shapes::with_noise(points, 0.02, seed + 10));
        std::vector<double> large, small;
        for (std::size_t i = 0; i < found.seeds.size(); ++i)
            (found.seeds[i].x() > 2 ? small : large).push_back(found.widths[i]);
        ASSERT_FALSE(small.empty());
        mean += median(large) / median(small) / 4;
    }
    EXPECT_GT(mean, 1.27); // 1.06 from single seeds, 1.21 from five at a time, 1 from all
}

TEST(LocalScales, NoisyPartsAreAsWideBesideCleanOnes)
{
    // Clean parts bear the narrowest width only.
    const double sigma = std::sqrt(4 * M_PI * M_PI * 0.3 / 20000);
    const Points exact = shapes::torus(20000, 1, 0.3, 5).points;
    const auto median_width = [](const Widths& found, double from)
    {
        std::vector<double> noisy;
        for (std::size_t i = 0; i < found.seeds.size(); ++i)
            if (found.seeds[i].x() > from)
                noisy.push_back(found.widths[i]);
        return median(noisy);
    };
    const Widths whole = choose(shapes::with_noise(exact, sigma, 6));
    const auto ratio = [&](double from)
    {
        const Widths part = choose(shapes::with_noise_beyond(from, exact, sigma, 6));
        return median_width(part, from) / median_width(whole, from);
    };
    EXPECT_NEAR(ratio(0), 1, 0.15);
    EXPECT_NEAR(ratio(0.9), 1, 0.25); // a seventh; 0.59 if its rim is taken for cleaner
}

// Two sheets that face away from each other.
TEST(LocalScales, TheOtherSideOfAWallIsNoBend)
{
    constexpr double apart = 6; // spacings
    Points exact;
    for (int i = 0; i < 60; ++i)
        for (int j = 0; j < 60; ++j)
            for (const double z : {0.0, apart})
                exact.emplace_back(i, j, z);
    const Points unsorted = shapes::with_noise(exact, 0.4, 7);
    Points points;
    Vectors normals;
    for (const int i : order_spatially(unsorted).order)
    {
        points.push_back(unsorted[i] / 60);
        normals.emplace_back(0, 0, exact[i].z() > 0 ? 1 : -1);
    }
    const BlockSearch search(points);
    const FitSamples samples{points, search, std::vector<double>(points.size(), 1), normals};
    const NoiseEstimate noise = estimate_noise(points, {});
    Vectors facing;
    for (const Point& seed : noise.seeds())
        facing.push_back(normals[search.nearest(seed)]);
    const auto median_width = [](const LocalScales& scales)
    {
        std::vector<double> widths;
        for (const LocalScale& scale : scales.at_seed)
            widths.push_back(scale.width);
        return median(widths);
    };
    EXPECT_GT(median_width(choose_fit_widths(samples, facing, noise, 1)),
              1.5 * median_width(choose_widths(points, search, noise, 1)));
}
