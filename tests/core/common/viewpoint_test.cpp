#include <recon/errors.h>
#include <recon/scan/viewpoint.h>
#include <recon/search/spatial_order.h>

#include "tests/scans.h"
#include "tests/shapes.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

using namespace recon;

namespace
{

struct Pose
{
    Eigen::Quaterniond turn;
    Vector shift;
};

const std::vector<Pose> poses = {
    {Eigen::Quaterniond::Identity(), Vector(0, 0, 0)},
    {Eigen::Quaterniond(Eigen::AngleAxisd(1.1, Vector(1, -2, 3).normalized())), Vector(3, -2, 7)},
    {Eigen::Quaterniond(Eigen::AngleAxisd(2.5, Vector(0, 1, 0.2).normalized())), Vector(5e5, 4.5e6, 200)},
};

Points put(const Points& points, const Pose& pose)
{
    Points result;
    for (const Point& p : points)
        result.push_back(pose.turn * p + pose.shift);
    return result;
}

/// What was seen row by row, column by column. \param rays of a row, none of which saw nothing.
Points by_columns(const Points& points, std::size_t columns)
{
    Points result;
    for (std::size_t j = 0; j < columns; ++j)
        for (std::size_t i = j; i < points.size(); i += columns)
            result.push_back(points[i]);
    return result;
}

} // namespace

TEST(ScanOrigin, IsFoundWhereverItIs)
{
    constexpr std::size_t columns = 240, around = 360;
    std::vector<Points> scans;
    for (const double step : {1e-6, 0.003})
    {
        scans.push_back(shapes::depth_frame(columns, step, 3).points);
        scans.push_back(by_columns(scans.back(), columns));
    }
    for (const double noise : {0.0, 0.01})
    {
        scans.push_back(shapes::laser_scan(around, noise, true, 3).points);
        scans.push_back(by_columns(scans.back(), around));
        scans.push_back(shapes::laser_scan(around, noise, false, 3).points); // some rays saw nothing
    }
    for (std::size_t k = 0; k < scans.size(); ++k)
        for (const Pose& pose : poses)
            for (const bool is_reversed : {false, true})
            {
                Points points = put(scans[k], pose);
                points.insert(points.begin() + 1'000, 3, points[999]); // copies
                if (is_reversed)
                    std::reverse(points.begin(), points.end());
                const auto found = find_scan_origin(points);
                ASSERT_TRUE(found) << k << " " << pose.shift.transpose() << " " << is_reversed;
                EXPECT_LT((*found - pose.shift).norm(), 0.03) << k << " " << is_reversed;
            }
}

// Clutter looks as what lies behind a surface does, and where rays saw nothing steps are twice as long.
TEST(ScanOrigin, IsFoundAmongClutterAndWhereRaysSawNothing)
{
    struct Scene
    {
        int boxes;
        bool in_room;
        double lost;
    };
    for (const auto& [count, in_room, lost] : {Scene{0, false, 0.05}, Scene{100, true, 0.1}, Scene{1'000, false, 0.05}})
        for (const std::uint64_t seed : {3, 4})
        {
            shapes::Random random(seed);
            const auto draw = [&](double least, double most)
            { return least + (most - least) * shapes::uniform(random); };
            std::vector<Box> boxes;
            for (int i = 0; i < count; ++i)
            {
                const Point centre(draw(-4, 4), draw(-4, 4), draw(-1.4, 1.6));
                const double half = draw(0.03, 0.08);
                if (centre.norm() > 1)
                    boxes.push_back({centre - Vector::Constant(half), centre + Vector::Constant(half)});
            }
            Points points;
            for (const Point& p : shapes::laser_scan(480, 0.01, in_room, seed, Point::Zero(), boxes).points)
                if (draw(0, 1) >= lost)
                    points.push_back(p + Vector(3, 2, 1));
            const auto found = find_scan_origin(points);
            ASSERT_TRUE(found) << count << " " << seed;
            EXPECT_LT((*found - Point(3, 2, 1)).norm(), 0.06) << count << " " << seed;
            EXPECT_EQ(find_scan_origins(points).places().size(), 1) << count << " " << seed;
        }
}

TEST(ScanOrigin, IsNoneOfOtherClouds)
{
    const Points frame = shapes::depth_frame(240, 0.003, 3).points;
    std::vector<Points> clouds{{}, {{0, 0, 0}}, Points(200, Point(1, 2, 3)), shapes::sphere(5'000, 1, 3).points};
    clouds.push_back(points_at(order_spatially(frame).order, frame));
    const std::size_t two_frames = clouds.size();
    clouds.push_back(frame);
    for (const Point& p : put(frame, poses[1]))
        clouds.back().push_back(p);
    clouds.emplace_back(); // noise across the rays
    for (const Point& p : shapes::with_noise(frame, 0.01, 5))
        clouds.back().push_back(p);
    clouds.emplace_back(); // a terrain with houses, from above
    for (int i = -60; i <= 60; ++i)
        for (int j = -60; j <= 60; ++j)
            clouds.back().emplace_back(i, j, i % 20 > 10 && j % 20 > 10 ? 30 : 0);
    // Bodies, meridian by meridian and circle by circle: a cube, a bumpy planet, half a sphere from pole to rim.
    for (const bool by_meridians : {false, true})
        for (int body = 0; body < 3; ++body)
        {
            clouds.emplace_back();
            for (int a = 0; a < 100 * 180; ++a)
            {
                const double over = body == 2 ? 0.0157 * (by_meridians ? a % 100 : a / 180)
                                              : 0.03 * (by_meridians ? a % 100 : a / 180) - 1.5,
                             about = (by_meridians ? a / 100 : a % 180) * 3.14159265358979 / 90;
                const Vector ray(std::cos(over) * std::cos(about), std::cos(over) * std::sin(about), std::sin(over));
                const double range = body == 0   ? 1 / ray.cwiseAbs().maxCoeff()
                                     : body == 1 ? 1 + 0.3 * std::sin(7 * about) * std::cos(5 * over)
                                                 : 1;
                clouds.back().push_back(range * ray);
            }
        }
    clouds.emplace_back(); // an empty room, column by column, whose ends meet far above it
    for (int j = 0; j < 360; ++j)
        for (int i = -60; i < 60; ++i)
        {
            const double over = i * 3.14159265358979 / 180, about = j * 3.14159265358979 / 180;
            const Vector ray(std::cos(over) * std::cos(about), std::cos(over) * std::sin(about), std::sin(over));
            double range = 1e300;
            for (int axis = 0; axis < 3; ++axis)
                range = std::min(range, (ray[axis] < 0 ? Point(-3, -2.5, -1.5) : Point(2.5, 3, 1.3))[axis] / ray[axis]);
            clouds.back().push_back(range * ray);
        }
    const Points room = clouds.back();
    for (const Point& p : room) // and another
        clouds.back().push_back(p + Vector(7, 0, 0));
    clouds.push_back(room);
    clouds.emplace_back(); // scans, and much that is none
    clouds.back() = shapes::laser_scans(240, 0, true, 3, {{0, 0, 0}, {-2, 0, 0}}).points;
    for (const Point& p : shapes::torus(int(clouds.back().size() / 7), 3, 1, 5).points)
        clouds.back().push_back(p + Vector(20, 0, 0));
    for (std::size_t k = 0; k < clouds.size(); ++k)
    {
        EXPECT_FALSE(find_scan_origin(clouds[k])) << k;
        EXPECT_EQ(find_scan_origins(clouds[k]).empty(), k != two_frames) << k;
    }
}

TEST(ScanOrigins, AreFoundOfScansThatFollowEachOther)
{
    const Points places{{0, 0, 0}, {-2, 1.5, 0.2}, {1, -1.8, -0.3}};
    // With few rays no window tells the place of the second scan.
    for (const auto& [around, noise] : {std::pair(300, 0.0), std::pair(300, 0.01), std::pair(200, 0.01)})
    {
        const OrientedSamples scans = shapes::laser_scans(around, noise, true, 3, places);
        for (const Pose& pose : poses)
            for (const bool is_reversed : {false, true})
            {
                const Points points = put(scans.points, pose);
                Points in_order = points, expected = put(places, pose);
                if (is_reversed)
                {
                    std::reverse(in_order.begin(), in_order.end());
                    std::reverse(expected.begin(), expected.end());
                }
                const Viewpoints found = find_scan_origins(in_order);
                ASSERT_EQ(found.places().size(), places.size()) << noise << is_reversed;
                for (std::size_t k = 0; k < places.size(); ++k)
                    EXPECT_LT((found.places()[k] - expected[k]).norm(), 0.1) << noise << is_reversed;
                int facing = 0;
                for (std::size_t i = 0; i < points.size(); ++i)
                    facing += (pose.turn * scans.normals[i]).dot(found.of(points[i]) - points[i]) > 0;
                EXPECT_GT(facing, 0.995 * double(points.size())) << noise << is_reversed;
            }
        EXPECT_TRUE(find_scan_origins(points_at(order_spatially(scans.points).order, scans.points)).empty());
    }
}

TEST(ScanOrigins, AreTheSameForAnyNumberOfThreadsAndCanBeCancelledOnTheWay)
{
    const Points points = shapes::laser_scans(200, 0.01, true, 3, {{0, 0, 0}, {-2, 1.5, 0.2}}).points;
    int reports = 0;
    double last = 0;
    const auto count = [&](double fraction, const std::string&)
    {
        ++reports;
        last = fraction;
        return true;
    };
    const Points places = find_scan_origins(points, 1, Progress(count)).places();
    ASSERT_EQ(places.size(), 2);
    EXPECT_EQ(find_scan_origins(points, 3).places(), places);
    EXPECT_GT(reports, 20);
    EXPECT_LE(last, 1);
    int left = reports / 2;
    const Progress halfway([&](double, const std::string&) { return --left > 0; });
    EXPECT_THROW(find_scan_origins(points, 1, halfway), Cancelled);
}

TEST(ScanOrigins, OneOfOneScan)
{
    const Points points = put(shapes::laser_scan(360, 0.01, true, 3).points, poses[1]);
    const Viewpoints found = find_scan_origins(points);
    ASSERT_EQ(found.places().size(), 1);
    EXPECT_EQ(found.places()[0], find_scan_origin(points));
    EXPECT_TRUE(find_scan_origins({}).empty());
}

TEST(ScanOrigins, OneOfRaysThatLeaveTheScannerBesideItsAxis)
{
    constexpr double beside = 0.05;
    for (const std::uint64_t seed : {3, 4, 5})
    {
        shapes::Random random(seed);
        Points points;
        for (const Point& p : shapes::laser_scan(480, 0.01, true, seed).points)
            if (shapes::uniform(random) >= 0.08)
                points.push_back(p + beside * Vector(p.x(), p.y(), 0).normalized() + Vector(3, 2, 1));
        const Viewpoints found = find_scan_origins(points);
        ASSERT_EQ(found.places().size(), 1) << seed;
        EXPECT_LT((found.places()[0] - Point(3, 2, 1)).norm(), 2 * beside) << seed;
    }
}

TEST(Viewpoints, AreThoseOfTheNearest)
{
    const Points places{{0, 0, 5}, {0, 0, -5}}, seen{{1, 0, 0}, {-1, 0, 0}};
    const UnitFrame frame({{100, 0, 0}, {104, 0, 0}});
    const Viewpoints viewpoints(places, seen, {0, 1}), in_frame = viewpoints.in(frame);
    for (const double x : {0.7, -0.7})
    {
        const Point p(x, 0, 0), place = places[x > 0 ? 0 : 1];
        EXPECT_EQ(viewpoints.of(p), place);
        EXPECT_EQ(in_frame.of(frame.to_unit(p)), frame.to_unit(place));
        EXPECT_EQ(Viewpoints(places[0]).of(p), places[0]);
    }
    EXPECT_TRUE(Viewpoints().empty());
    EXPECT_TRUE(Viewpoints().in(frame).empty());
}

TEST(FindViewpoints, FindsPixelsInAnyOrderAndOthersByTheirs)
{
    const Points frame = shapes::depth_frame(240, 0.003, 3).points, moved = put(frame, poses[1]);
    const auto in_order = [](const Points& points) { return points_at(order_spatially(points).order, points); };
    EXPECT_EQ(find_viewpoints(in_order(frame), 1).places(), Points{Point::Zero()});
    const Viewpoints found = find_viewpoints(moved, in_order(moved), 1);
    ASSERT_EQ(found.places().size(), 1);
    EXPECT_LT((found.places()[0] - poses[1].shift).norm(), 0.03);
    EXPECT_TRUE(find_viewpoints(in_order(moved), 1).empty());
}

// Rays that nothing answered have the scanner's place; moved, and in no order, nothing else tells it.
TEST(FindViewpoints, FindsWhereRaysThatNothingAnsweredCameFrom)
{
    Points scan = put(shapes::laser_scan(360, 0.01, false, 3).points, poses[1]);
    scan = points_at(order_spatially(scan).order, scan);
    const auto with_copies = [&](const Point& place, std::size_t count)
    {
        Points points = scan;
        points.insert(points.end(), count, place);
        return points;
    };
    const auto find = [](const Points& points) { return find_viewpoints(points, 1).places(); };
    EXPECT_EQ(find(with_copies(poses[1].shift, 100)), Points{poses[1].shift});
    EXPECT_EQ(find(with_copies(poses[1].shift, 99)), Points{});
    EXPECT_EQ(find(with_copies(scan[5], 500)), Points{}) << "copies of a reading";
}
