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

TEST(FindDepthCamera, FindsALaserScanner)
{
    for (const bool in_room : {false, true})
        for (const double noise : {0.0, 0.01})
            for (const int axis : {0, 1, 2})
            {
                Points points = shapes::laser_scan(360, noise, in_room, 3).points;
                for (Point& p : points)
                    p = Point(p[(3 - axis) % 3], p[(4 - axis) % 3], p[(5 - axis) % 3]);
                points.insert(points.end(), 100, Point::Zero()); // rays that hit nothing
                const auto scanner = find_depth_camera(points);
                ASSERT_TRUE(scanner) << in_room << " " << noise << " " << axis;
                EXPECT_EQ(scanner->place, Point::Zero());
                EXPECT_NEAR(scanner->pixel, 2 * 3.14159265 / 360, 1e-4);
                EXPECT_FALSE(find_coarse_depth_camera(points));
            }
}

TEST(FindDepthCamera, TakesNoBodyInPolarCoordinatesForAScan)
{
    // Seen from within: an egg, a cube, a bumpy planet; and a scan beside its place.
    std::vector<Points> clouds(3);
    for (int i = -100; i <= 100; ++i)
        for (int j = 0; j < 360; ++j)
        {
            const double over = i * 0.015, about = j * 3.14159265358979 / 180;
            const Vector ray(std::cos(over) * std::cos(about), std::cos(over) * std::sin(about), std::sin(over));
            clouds[0].push_back(ray / std::sqrt(ray.squaredNorm() - 0.9 * ray.z() * ray.z()));
            clouds[1].push_back(ray / ray.cwiseAbs().maxCoeff());
            clouds[2].push_back(ray * (1 + 0.3 * std::sin(7 * about) * std::cos(5 * over)));
        }
    clouds.push_back(shapes::laser_scan(360, 0.01, true, 3).points);
    for (Point& p : clouds.back())
        p += Vector(0.1, 0, 0.2);
    for (std::size_t k = 0; k < clouds.size(); ++k)
        EXPECT_FALSE(find_depth_camera(clouds[k])) << k;
    EXPECT_FALSE(find_depth_camera(Points(5000, Point::Zero())));
}
