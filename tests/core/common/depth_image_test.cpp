#include <recon/scan/depth_image.h>
#include <recon/search/spatial_order.h>

#include "tests/scans.h"
#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

using namespace recon;

namespace
{

Points in_order(const Points& points)
{
    return points_at(order_spatially(points).order, points);
}

} // namespace

TEST(FindDepthCamera, FindsItHoweverCoarseItsDepths)
{
    for (const double step : {1e-6, 0.003, 0.02})
        for (const int axis : {0, 1, 2})
            for (const double side : {1.0, -1.0})
            {
                Points points = shapes::depth_frame(120, step, 3).points;
                for (Point& p : points)
                    p = side * Point(p[(3 - axis) % 3], p[(4 - axis) % 3], p[(5 - axis) % 3]);
                EXPECT_TRUE(find_depth_camera(points)) << step << " " << axis << " " << side;
            }
}

TEST(FindDepthCamera, FindsNoneElsewhere)
{
    const Points frame = shapes::depth_frame(120, 0.003, 3).points;
    Points moved, thinned, terrain, plane;
    for (const Point& p : frame)
        moved.push_back(p + Point(1, 0.5, 0));
    shapes::Random random(5);
    for (const Point& p : frame)
        if (shapes::uniform(random) < 0.2)
            thinned.push_back(p);
    for (int i = -50; i <= 50; ++i)
        for (int j = -50; j <= 50; ++j)
        {
            terrain.emplace_back(i, j, 100 + 10 * std::sin(0.1 * i));
            plane.emplace_back(i, j, 100 + 0.5 * i);
        }
    for (const Points& points :
         {moved, thinned, terrain, plane, shapes::sphere(5000, 1, 3).points, Points{}, Points{{0, 0, 0}},
          Points(200, Point(0, 0, 1)), Points(frame.begin(), frame.begin() + 50)})
        EXPECT_FALSE(find_depth_camera(points)) << points.size();
}

TEST(FindDepthCamera, TellsItsSteps)
{
    const auto fine = find_depth_camera(shapes::depth_frame(120, 1e-6, 3).points);
    ASSERT_TRUE(fine);
    EXPECT_NEAR(fine->pixel, 1.0 / 120, 1e-9);
    const Points coarse_frame = in_order(shapes::depth_frame(120, 0.01, 3).points);
    EXPECT_FALSE(find_coarse_depth_camera(in_order(shapes::depth_frame(120, 0.0005, 3).points)));
    const auto coarse = find_coarse_depth_camera(coarse_frame);
    ASSERT_TRUE(coarse);
    EXPECT_NEAR(coarse->step_at(Point(0, 0, 2)), 4 * 0.01, 0.01);
    EXPECT_NEAR(coarse->step_at(Point(1, 0, 4)), 16 * 0.01, 0.03);
    const UnitFrame frame(coarse_frame);
    EXPECT_NEAR(coarse->in(frame).step_at(frame.to_unit(Point(0, 0, 2))) * frame.scale(), 4 * 0.01, 0.01);
}
