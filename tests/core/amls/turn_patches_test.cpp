#include "filter_amls/sides/turn_patches.h"

#include <recon/search/spatial_order.h>
#include <recon/triangulation/delaunay.h>
#include <recon/triangulation/polar_balls.h>

#include "tests/shapes.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

using namespace recon;

namespace
{

/// Even samples one unit apart, and patches of them.
struct Sheets
{
    Points points;
    Vectors normals;

    /// A square of side `side` spanned from `origin`; the normals of what `is_turned` says are turned over.
    void add(const Point& origin, const Vector& u, const Vector& v, int side,
             const std::function<bool(double, double)>& is_turned)
    {
        shapes::Random random(points.size() + 1);
        const auto jitter = [&] { return 0.3 * (shapes::uniform(random) - 0.5); };
        for (int i = 0; i < side; ++i)
            for (int j = 0; j < side; ++j)
            {
                points.push_back(origin + (i + jitter()) * u + (j + jitter()) * v + 0.05 * jitter() * u.cross(v));
                normals.push_back((is_turned(i, j) ? -1.0 : 1.0) * u.cross(v));
            }
    }
    double turn(bool has_ground = false)
    {
        const std::vector<int> order = order_spatially(points).order;
        Points sorted = points_at(order, points);
        Vectors sorted_normals = points_at(order, normals);
        constexpr double scale = 0.01;
        for (Point& p : sorted)
            p *= scale;
        Points with_corners = sorted;
        append_box_corners(with_corners);
        const Triangulation delaunay = triangulate_delaunay(with_corners);
        const double turned =
            turn_patches(delaunay, sorted, std::vector<double>(points.size(), scale), has_ground, sorted_normals, 1);
        points = std::move(sorted);
        for (Point& p : points)
            p /= scale;
        normals = std::move(sorted_normals);
        return turned;
    }
    double share_along(const Vector& direction) const
    {
        const auto along =
            std::count_if(normals.begin(), normals.end(), [&](const Vector& n) { return n.dot(direction) > 0; });
        return double(along) / double(normals.size());
    }
};

const Vector x = Vector::UnitX(), y = Vector::UnitY(), z = Vector::UnitZ();

} // namespace

TEST(TurnPatches, TurnsTheSmallerSideOfASeam)
{
    for (const bool has_ground : {false, true})
    {
        Sheets sheet;
        sheet.add(Point::Zero(), x, y, 30, [](double i, double) { return i < 9.5; });
        EXPECT_NEAR(sheet.turn(has_ground), 1.0 / 3, 1e-9);
        EXPECT_EQ(sheet.share_along(z), 1);
        EXPECT_EQ(sheet.turn(has_ground), 0);
    }
}

TEST(TurnPatches, TurnsAnIslandAndEverySecondStripe)
{
    Sheets stripes;
    stripes.add(Point::Zero(), x, y, 48,
                [](double i, double j)
                { return (i > 12.5 && i < 24.5) || (i > 29.5 && std::hypot(i - 36, j - 20) < 6); });
    stripes.turn();
    EXPECT_TRUE(stripes.share_along(z) == 1 || stripes.share_along(z) == 0);
}

TEST(TurnPatches, LeavesCreasesBridgesAndThinWallsAlone)
{
    Sheets crease; // a ridge
    crease.add(Point::Zero(), x, y, 30, [](double, double) { return false; });
    crease.add(Point(-0.8, 0, -1), Vector(-z), y, 20, [](double, double) { return true; });
    EXPECT_EQ(crease.turn(), 0);

    Sheets bridge; // a wall on a floor, its top turned where two points touch a shelf
    bridge.add(Point::Zero(), x, y, 30, [](double, double) { return false; });
    bridge.add(Point(30, 14, 0), x, y, 2, [](double, double) { return true; });
    bridge.add(Point(32, 14, 0), z, Vector(-y), 10, [](double, double) { return false; });
    EXPECT_EQ(bridge.turn(), 0);

    for (const double thickness : {0.15, 0.5, 1.5})
    {
        Sheets plate;
        plate.add(Point::Zero(), x, y, 20, [](double, double) { return false; });
        plate.add(Point(0.5, 0.5, -thickness), x, y, 20, [](double, double) { return true; });
        EXPECT_EQ(plate.turn(), 0) << thickness;
    }
}

TEST(TurnPatches, OfFewPointsNeighboursDecide)
{
    Sheets sheet;
    sheet.add(Point::Zero(), x, y, 20, [](double i, double j) { return i < 3.5 && j < 3.5; });
    EXPECT_EQ(sheet.turn(), 0);
}
