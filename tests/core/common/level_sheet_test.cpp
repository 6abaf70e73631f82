#include <recon/mesh/level_sheet.h>

#include "tests/shapes.h"

#include <Eigen/Geometry>

#include <gtest/gtest.h>

#include <cmath>

using namespace recon;

namespace
{

constexpr double pi = 3.14159265358979323846;

struct Sheet
{
    Points points;
    Vectors normals;

    void append(const Point& p, const Vector& normal)
    {
        points.push_back(p);
        normals.push_back(normal);
    }
    void turn()
    {
        for (Vector& normal : normals)
            normal = -normal;
    }
};

/// A table seen from above (z), tilted afterwards, and a ball on it away from its middle.
Sheet table_with_ball(double radius)
{
    Sheet sheet;
    for (int i = -50; i <= 50; ++i)
        for (int j = -50; j <= 50; ++j)
            sheet.append(Point(0.02 * i, 0.02 * j, 0), Vector::UnitZ());
    const int count = int(pi * 4 * radius * radius / (0.02 * 0.02));
    const OrientedSamples ball = shapes::sphere(count, radius, 3);
    for (std::size_t i = 0; i < ball.points.size(); ++i)
        sheet.append(ball.points[i] + Point(0.3, 0.1, radius), ball.normals[i]);
    const Eigen::Quaterniond tilt(Eigen::AngleAxisd(1.1, Vector(0.3, 1, 0.2).normalized()));
    for (Point& p : sheet.points)
        p = tilt * p;
    for (Vector& normal : sheet.normals)
        normal = tilt * normal;
    return sheet;
}

/// A can without a bottom, outward.
Sheet open_can(double height)
{
    Sheet sheet;
    for (double r = 0.01; r < 0.5; r += 0.02)
        for (int k = 0; k < int(2 * pi * r / 0.02); ++k)
        {
            const double angle = k * 0.02 / r;
            sheet.append(Point(r * std::cos(angle), r * std::sin(angle), height), Vector::UnitZ());
        }
    for (double z = 0; z < height; z += 0.02)
        for (int k = 0; k < 157; ++k)
        {
            const Vector away(std::cos(0.04 * k), std::sin(0.04 * k), 0);
            sheet.append(0.5 * away + z * Vector::UnitZ(), away);
        }
    return sheet;
}

/// Floor and walls of a room of 2 x 2 x height, seen from within, with or without a ceiling.
Sheet room(double height, bool has_ceiling)
{
    Sheet sheet;
    for (double x = -0.99; x < 1; x += 0.02)
    {
        for (double y = -0.99; y < 1; y += 0.02)
        {
            sheet.append(Point(x, y, 0), Vector::UnitZ());
            if (has_ceiling)
                sheet.append(Point(x, y, height), -Vector::UnitZ());
        }
        for (double z = 0.01; z < height; z += 0.02)
            for (const double side : {-1.0, 1.0})
            {
                sheet.append(Point(side, x, z), -side * Vector::UnitX());
                sheet.append(Point(x, side, z), -side * Vector::UnitY());
            }
    }
    return sheet;
}

} // namespace

TEST(IsUpsideDown, TheFloorOfARoomWithoutACeilingFacesUp)
{
    for (const double height : {0.6, 1.0})
    {
        Sheet open = room(height, false), closed = room(height, true);
        for (const bool is_turned : {false, true})
        {
            EXPECT_EQ(is_upside_down(open.points, open.normals), is_turned) << height;
            EXPECT_FALSE(is_upside_down(closed.points, closed.normals)) << height;
            open.turn();
            closed.turn();
        }
    }
}

TEST(FindGround, ATableFacesWhatStandsOnIt)
{
    for (const double radius : {0.1, 0.2, 0.4}) // 0.03 to 0.5 of the table's area
    {
        Sheet sheet = table_with_ball(radius);
        for (const bool is_turned : {false, true})
        {
            const std::optional<Ground> ground = find_ground(sheet.points, sheet.normals);
            ASSERT_TRUE(ground) << radius;
            EXPECT_EQ(ground->faces_things, !is_turned) << radius;
            EXPECT_NEAR(double(ground->members.size()), 101 * 101, 0.05 * 101 * 101);
            EXPECT_EQ(is_upside_down(sheet.points, sheet.normals), is_turned) << radius;
            sheet.turn();
        }
    }
}

TEST(FindGround, AShadowMayNotchItsRim)
{
    Sheet sheet;
    for (double x = -0.99; x < 1; x += 0.02)
        for (double y = -0.99; y < 1; y += 0.02)
            if (x < 0.55 || std::abs(y - 0.1) > 0.3)
                sheet.append(Point(x, y, 0), Vector::UnitZ());
    const OrientedSamples ball = shapes::sphere(700, 0.15, 3);
    for (std::size_t i = 0; i < ball.points.size(); ++i)
        sheet.append(ball.points[i] + Point(0.7, 0.1, 0.15), ball.normals[i]);
    const std::optional<Ground> ground = find_ground(sheet.points, sheet.normals);
    ASSERT_TRUE(ground);
    EXPECT_TRUE(ground->faces_things);
}

TEST(FindGround, NoneWhereWallsStandAtTheRimOrNothingStandsOut)
{
    for (const double height : {0.2, 0.5, 2.0})
        EXPECT_FALSE(find_ground(open_can(height).points, open_can(height).normals)) << height;
    Sheet bare = table_with_ball(0.1);
    bare.points.resize(101 * 101);
    bare.normals.resize(101 * 101);
    EXPECT_FALSE(find_ground(bare.points, bare.normals));
    const OrientedSamples dome = shapes::sphere(5000, 1, 2);
    EXPECT_FALSE(find_ground(dome.points, dome.normals));
    EXPECT_FALSE(find_ground({}, {}));
    EXPECT_FALSE(find_ground({Point::Zero()}, {Vector::Zero()}));
}

TEST(FindGround, NoneWhereAsMuchStandsOutOnBothSides)
{
    Sheet sheet = table_with_ball(0.2);
    const Vector up = sheet.normals.front();
    const std::size_t table = 101 * 101, all = sheet.points.size();
    for (std::size_t i = table; i < all; ++i)
        sheet.append(sheet.points[i] - 2 * up.dot(sheet.points[i]) * up, sheet.normals[i]);
    EXPECT_FALSE(find_ground(sheet.points, sheet.normals));
}
