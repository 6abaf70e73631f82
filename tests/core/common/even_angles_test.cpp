#include <recon/scan/even_angles.h>
#include <recon/search/spatial_order.h>

#include "tests/scans.h"
#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

using namespace recon;

namespace
{

/// What a scanner at the origin sees, in no order that tells it.
Points scan(double noise, bool in_room)
{
    const Points points = shapes::laser_scan(360, noise, in_room, 3).points;
    return points_at(order_spatially(points).order, points);
}

Points moved(Points points, const Vector& shift)
{
    for (Point& p : points)
        p += shift;
    return points;
}

} // namespace

TEST(ScannerAtOrigin, IsFoundInAnyOrder)
{
    for (const bool in_room : {false, true})
        for (const double noise : {0.0, 0.01, 0.05})
            for (const int axis : {0, 1, 2})
            {
                Points points = scan(noise, in_room);
                for (Point& p : points)
                    p = Point(p[(3 - axis) % 3], p[(4 - axis) % 3], p[(5 - axis) % 3]);
                points.insert(points.end(), 100, Point::Zero()); // rays that hit nothing
                EXPECT_TRUE(is_scanner_at_origin(points)) << in_room << " " << noise << " " << axis;
            }
}

TEST(ScannerAtOrigin, IsFoundThoughSomeRaysSawNothing)
{
    shapes::Random random(7);
    Points points;
    for (const Point& p : scan(0.01, true))
        if (shapes::uniform(random) < 0.95)
            points.push_back(p);
    EXPECT_TRUE(is_scanner_at_origin(points));
}

TEST(ScannerAtOrigin, IsNoneOfOtherClouds)
{
    const Points room = scan(0.01, true);
    std::vector<Points> clouds{{},
                               {{0, 0, 0}},
                               Points(5'000, Point::Zero()),
                               Points(5'000, Point(1, 2, 3)),
                               shapes::sphere(5'000, 1, 3).points,
                               moved(shapes::sphere(5'000, 1, 3).points, {0.5, 0.3, 0}),
                               shapes::torus(20'000, 3, 1, 3).points,
                               moved(shapes::torus(20'000, 3, 1, 3).points, {3, 0, 0}),
                               moved(room, {1.5, 1, 0})};
    clouds.push_back(clouds[7]); // copies
    clouds.back().insert(clouds.back().end(), clouds[7].begin(), clouds[7].end());
    clouds.emplace_back(); // thinned
    shapes::Random random(5);
    for (const Point& p : room)
        if (shapes::uniform(random) < 0.2)
            clouds.back().push_back(p);
    clouds.push_back(room); // and another beside it
    for (const Point& p : moved(room, {1.5, 1, 0}))
        clouds.back().push_back(p);
    // Bodies in polar coordinates, seen from within, far from the poles: an egg, a cube, a bumpy planet.
    for (int body = 0; body < 3; ++body)
    {
        clouds.emplace_back();
        for (int i = -50; i <= 50; ++i)
            for (int j = 0; j < 360; ++j)
            {
                const double over = i * 0.015, about = j * 3.14159265358979 / 180;
                const Vector ray(std::cos(over) * std::cos(about), std::cos(over) * std::sin(about), std::sin(over));
                const double range = body == 0   ? 1 / std::sqrt(ray.squaredNorm() - 0.9 * ray.z() * ray.z())
                                     : body == 1 ? 1 / ray.cwiseAbs().maxCoeff()
                                                 : 1 + 0.3 * std::sin(7 * about) * std::cos(5 * over);
                clouds.back().push_back(range * ray);
            }
    }
    clouds.push_back(clouds.back()); // and what strays within the last
    for (std::size_t i = 0; i < clouds.back().size(); i += 400)
        clouds.back()[i] *= 0.5;
    for (std::size_t k = 0; k < clouds.size(); ++k)
        EXPECT_FALSE(is_scanner_at_origin(clouds[k])) << k;
}
