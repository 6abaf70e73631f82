#include <recon/noise/sheet_stack.h>
#include <recon/search/block_search.h>
#include <recon/search/spatial_order.h>

#include "tests/scans.h"
#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

using namespace recon;

namespace
{

/// Of every `stride`-th point: whether it was found to lie in a stacked sheet, which `visit` is then shown with the
/// point and its neighbours.
double share_in_stacks(const Points& cloud, std::size_t stride,
                       const std::function<void(const StackedSheet&, const Point&, const Points&)>& visit = {})
{
    const Points points = points_at(order_spatially(cloud).order, cloud);
    const BlockSearch search(points);
    int found = 0, asked = 0;
    for (std::size_t i = 0; i < points.size(); i += stride, ++asked)
    {
        std::vector<int> near(most_around_stack);
        std::vector<double> squared(most_around_stack);
        const int count = search.nearest(points[i], most_around_stack, near.data(), squared.data());
        if (const auto sheet = find_stacked_sheet(points, points[i], near.data(), squared.data(), count))
        {
            ++found;
            near.resize(std::size_t(count));
            if (visit)
                visit(*sheet, points[i], points_at(near, points));
        }
    }
    return double(found) / asked;
}

} // namespace

TEST(FindStackedSheet, FindsNoiseDensityAndMembersOfASheet)
{
    const double noise = 0.15;
    const Points stack = shapes::with_noise(shapes::stack_of_sheets(12, 30, 1.8, 3), noise, 4);
    std::vector<double> sigma, density;
    int strangers = 0, members = 0;
    const double share = share_in_stacks(stack, 7,
                                         [&](const StackedSheet& sheet, const Point& centre, const Points& near)
                                         {
                                             sigma.push_back(sheet.sigma);
                                             density.push_back(sheet.density);
                                             EXPECT_TRUE(std::is_sorted(sheet.members.begin(), sheet.members.end()));
                                             for (const int k : sheet.members)
                                                 strangers += std::abs(near[std::size_t(k)].z() - centre.z()) > 0.9;
                                             members += int(sheet.members.size());
                                         });
    EXPECT_GT(share, 0.6);
    std::sort(sigma.begin(), sigma.end());
    std::sort(density.begin(), density.end());
    EXPECT_NEAR(sigma[sigma.size() / 2], noise, 0.1 * noise);
    EXPECT_NEAR(density[density.size() / 2], 1, 0.15);
    EXPECT_LT(strangers, 0.02 * members);
}

TEST(FindStackedSheet, FindsCurvedSheets)
{
    Points shells;
    for (const double radius : {8.0, 9.8, 11.6, 13.4})
    {
        const Points shell = shapes::sphere(int(4 * M_PI * radius * radius), radius, 5).points;
        shells.insert(shells.end(), shell.begin(), shell.end());
    }
    EXPECT_GT(share_in_stacks(shells, 7), 0.5);
}

TEST(FindStackedSheet, FindsNoneInThickNoiseOrOnOneSurface)
{
    const Points ball = shapes::sphere(8000, 1, 6).points;
    EXPECT_LT(share_in_stacks(ball, 7), 0.01);
    const double spacing = std::sqrt(4 * M_PI / 8000);
    for (const double noise : {0.3, 1.0, 3.0})
        EXPECT_LT(share_in_stacks(shapes::with_noise(ball, noise * spacing, 7), 7), 0.1) << noise;
}

TEST(FindStackedSheet, FindsNoneAmongFewEqualOrCollinearPoints)
{
    EXPECT_EQ(share_in_stacks(shapes::sphere(30, 1, 1).points, 1), 0);
    Points line;
    for (int i = 0; i < 300; ++i)
        line.emplace_back(i, 2 * i, 0);
    EXPECT_EQ(share_in_stacks(line, 11), 0);
    const Points equal(200, Point(1, 2, 3));
    std::vector<int> near(equal.size());
    for (int i = 0; i < int(near.size()); ++i)
        near[std::size_t(i)] = i;
    EXPECT_FALSE(find_stacked_sheet(equal, equal[0], near.data(), std::vector<double>(equal.size(), 0).data(), 200));
}

TEST(FindStackedSheet, FindsNoneInTheStepsAndRowsOfADepthCamera)
{
    // Depths of the wall lie 1.5 pixels apart, and pixels of the floor in planes of rows.
    EXPECT_LT(share_in_stacks(shapes::depth_frame(240, 0.0015, 4).points, 37), 0.15);
}
