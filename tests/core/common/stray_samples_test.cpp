#include <recon/noise/stray_samples.h>
#include <recon/search/spatial_order.h>

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace recon;

namespace
{

double measure(const Points& points, int threads = 1)
{
    const Points samples = points_at(order_spatially(points).order, points);
    return measure_strays(samples, BlockSearch(samples), threads);
}

const Points& exact_torus()
{
    static const Points points = shapes::torus(20'000, 1, 0.3, 3).points;
    return points;
}

double spacing()
{
    return std::sqrt(4 * EIGEN_PI * EIGEN_PI * 0.3 / double(exact_torus().size()));
}

} // namespace

TEST(MeasureStrays, TellsNoisyOnesAmongExactOnes)
{
    for (const double share : {0.05, 0.1, 0.3})
        for (const double noise : {0.5, 1.0})
            for (const double others : {0.0, 0.03})
            {
                const Points points = shapes::with_noise(exact_torus(), others * spacing(), 4);
                const double strays = measure(shapes::with_noisy_share(share, points, noise * spacing(), 5));
                EXPECT_GT(strays, 0.1 * share) << share << ' ' << noise << ' ' << others;
                EXPECT_LT(strays, share) << share << ' ' << noise << ' ' << others;
            }
}

TEST(MeasureStrays, EdgesThinWallsAndNoiseEverywhereHaveNone)
{
    EXPECT_LT(measure(exact_torus()), 0.002);
    EXPECT_LT(measure(shapes::torus(2'000, 1, 0.3, 3).points), 0.004);
    EXPECT_LT(measure(shapes::box(3'000, {3, 2, 1}, 3).points), 0.004);
    for (const double thickness : {0.8, 1.2, 2.0})
        EXPECT_LT(measure(shapes::thin_plate(40, thickness, 5)), 0.004) << thickness;
    for (const double noise : {0.1, 0.5})
        EXPECT_LT(measure(shapes::with_noise(exact_torus(), noise * spacing(), 4)), 0.01) << noise;
}

TEST(MeasureStrays, OutliersAreNone)
{
    Points points = exact_torus();
    for (const Point& p : shapes::scattered(1'000, {3, 3, 1}, 6))
        points.push_back(p);
    EXPECT_LT(measure(points), 0.006);
}

TEST(MeasureStrays, FewPointsAndAnyNumberOfThreads)
{
    EXPECT_EQ(measure({}), 0);
    EXPECT_EQ(measure(Points(10, Point(1, 2, 3))), 0);
    EXPECT_EQ(measure(shapes::torus(15, 1, 0.3, 3).points), 0);
    const Points noisy = shapes::with_noisy_share(0.1, exact_torus(), spacing(), 5);
    EXPECT_EQ(measure(noisy, 1), measure(noisy, 3));
}
