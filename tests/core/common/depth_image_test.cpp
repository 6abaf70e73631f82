#include <recon/depth_image.h>

#include "tests/shapes.h"

#include <gtest/gtest.h>

using namespace recon;

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
