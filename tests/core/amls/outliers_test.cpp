#include "project_all.h"

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace recon;

TEST(AmlsSurface, TellsEdgesFromOutliers)
{
    // Samples on the edges themselves, farther from the surface that rounds them than the noise that there is not.
    constexpr int n = 24;
    Points points;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j)
            for (int k = 0; k <= n; ++k)
                if (std::min({i, j, k}) == 0 || std::max({i, j, k}) == n)
                    points.emplace_back(i, j, k);
    const std::size_t genuine = points.size();
    for (const double off : {8.0, 10.0, 12.0})
    {
        points.emplace_back(n + off, 12.3, off);
        points.emplace_back(off, -off, 11.1);
    }
    const AmlsProjection result = project_all(points);
    EXPECT_GT(result.count(ProjectionStatus::kept), 0);
    for (std::size_t i = 0; i < points.size(); ++i)
    {
        EXPECT_EQ(result.status[i] == ProjectionStatus::outlier, i >= genuine)
            << points[i].transpose() << " status " << int(result.status[i]) << " w " << result.widths[i] << " "
            << result.spacings[i] << " " << result.points[i].transpose();
        EXPECT_TRUE(is_moved(result.status[i]) || result.points[i] == points[i]);
    }
    // The same is said of a point when not all are asked.
    const Points half(points.begin() + std::ptrdiff_t(genuine / 2), points.end());
    const AmlsProjection of_half = project_to_amls(half, build_amls_surface(points));
    EXPECT_TRUE(
        std::equal(of_half.status.begin(), of_half.status.end(), result.status.begin() + std::ptrdiff_t(genuine / 2)));
}

TEST(AmlsSurface, LeavesOutliersAlone)
{
    Points points = shapes::with_noise(shapes::sphere(8000, 1, 21).points, 0.01, 22);
    const std::size_t n = points.size();
    for (const Point& p : shapes::scattered(80, {6, 6, 6}, 23))
        points.push_back(p);
    const AmlsProjection result = project_all(points);
    int far = 0, left = 0;
    for (std::size_t i = n; i < points.size(); ++i)
        if (shapes::distance_to_sphere(points[i], 1) > 0.5)
        {
            ++far;
            left += result.status[i] == ProjectionStatus::outlier && result.points[i] == points[i];
        }
    ASSERT_GT(far, 40);
    EXPECT_EQ(left, far);
    const Points inliers(result.points.begin(), result.points.begin() + std::ptrdiff_t(n));
    EXPECT_LT(shapes::rms(inliers, [](const Point& p) { return shapes::distance_to_sphere(p, 1); }), 0.003);
}

TEST(AmlsSurface, FindsOutliersThatAreNotQuiteAlone)
{
    // One outlier for 20 points: each has some others within the window of a noisy, dense surface. Beside little noise
    // they are no noisy patch. A second look, without those found first, finds half of the others.
    for (const double sigma : {0.01, 0.004})
    {
        Points points = shapes::with_noise(shapes::sphere(60000, 1, 46).points, sigma, 48);
        const std::size_t genuine = points.size();
        for (const Point& p : shapes::scattered(int(genuine) / 20, {2.4, 2.4, 2.4}, 47))
            points.push_back(p);
        const AmlsProjection result = project_all(points);
        int mistaken = 0, far = 0, found = 0;
        for (std::size_t i = 0; i < points.size(); ++i)
        {
            const bool flagged = result.status[i] == ProjectionStatus::outlier;
            if (i < genuine)
                mistaken += flagged;
            else if (shapes::distance_to_sphere(points[i], 1) > 0.2)
            {
                ++far;
                found += flagged;
            }
        }
        ASSERT_GT(far, 1000);
        EXPECT_GT(found, 0.97 * far) << far << ", " << sigma;
        EXPECT_LT(mistaken, 0.001 * double(genuine)) << sigma;
    }
}

TEST(AmlsSurface, SparsePartBesideDenseOneIsNoOutlier)
{
    // The belt is 20 times as dense as the rest, whose samples have the belt's scales by their nearest seed.
    Points points = shapes::sphere(1200, 1, 61).points;
    const std::size_t sparse = points.size();
    for (const Point& p : shapes::sphere(24000, 1, 62).points)
        if (std::abs(p.z()) < 0.1)
            points.push_back(p);
    for (const double sigma : {0.0, 0.003})
    {
        const AmlsProjection result = project_all(shapes::with_noise(points, sigma, 63));
        EXPECT_EQ(result.count(ProjectionStatus::outlier), 0);
        for (std::size_t i = 0; i < sparse; ++i)
            EXPECT_LT(shapes::distance_to_sphere(result.points[i], 1), 0.02);
    }
}

TEST(AmlsSurface, FindsLonePointsAFewSpacingsOffACleanSurface)
{
    const int n = 8000, lone = 12;
    const double spacing = std::sqrt(4 * 3.14159265 / n);
    for (const double off : {2.5, 4.0})
    {
        Points points = shapes::sphere(n, 1, 64).points;
        for (const Point& p : shapes::sphere(lone, 1 + off * spacing, 65).points)
            points.push_back(p);
        const AmlsProjection result = project_all(points);
        EXPECT_EQ(result.count(ProjectionStatus::outlier), lone);
        EXPECT_EQ(std::count(result.status.begin() + n, result.status.end(), ProjectionStatus::outlier), lone);
    }
}
