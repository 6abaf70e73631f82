#include <recon/noise/rounding.h>
#include <recon/search/spatial_order.h>

#include "tests/lattices.h"
#include "tests/scans.h"
#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace recon;

namespace
{

Points torus()
{
    return shapes::torus(40000, 1, 0.4, 1).points;
}

Rounding find_in_order(const Points& points)
{
    return find_rounding(points_at(order_spatially(points).order, points));
}

/// Heights of a hilly terrain over a grid of so many places each way.
Points hills(int side)
{
    Points points;
    for (int x = 0; x < side; ++x)
        for (int y = 0; y < side; ++y)
            points.emplace_back(x, y, 8 * std::sin(0.1 * x) * std::cos(0.13 * y) + 0.4 * x);
    return points;
}

} // namespace

TEST(FindRounding, FindsTheStepsOfALattice)
{
    const Points voxels = shapes::rounded(torus(), Vector::Constant(0.05));
    const Rounding found = find_in_order(voxels);
    EXPECT_NEAR(found.lattice_step, 0.05, 1e-9);
    EXPECT_NEAR(found.in(UnitFrame(voxels)).lattice_step * UnitFrame(voxels).scale(), 0.05, 1e-9);
    Points moved = voxels, as_floats = voxels;
    for (Point& p : moved)
        p = 1000 * p + Point(5e5, -3e4, 12);
    for (Point& p : as_floats)
        p = (p + Point(0.123, 4.56, -7.8)).cast<float>().cast<double>();
    EXPECT_NEAR(find_in_order(moved).lattice_step, 50, 1e-3);
    EXPECT_NEAR(find_in_order(as_floats).lattice_step, 0.05, 1e-5);
}

TEST(FindRounding, TakesTheLongestStepButOfHeightsTheirs)
{
    const Rounding slices = find_in_order(shapes::rounded(torus(), Vector(0.04, 0.04, 0.06)));
    EXPECT_NEAR(slices.lattice_step, 0.06, 1e-9);
    EXPECT_LT((slices.lattice_steps - Vector(0.04, 0.04, 0.06)).norm(), 1e-9);
    EXPECT_NEAR(find_in_order(shapes::rounded(hills(60), Vector(1, 1, 0.8))).lattice_step, 0.8, 1e-9);
}

// Metres far north come in steps of half a metre in single precision, while the other axes are fine.
TEST(FindRounding, FindsAxesThatAreRoundedMoreCoarselyThanThePointsAreDense)
{
    for (const Vector& steps : {Vector(1e-9, 0.05, 1e-9), Vector(1e-7, 0.05, 0.003), Vector(1e-9, 1e-9, 0.1)})
    {
        const Rounding found = find_in_order(shapes::rounded(torus(), steps));
        EXPECT_NEAR(found.lattice_step, steps.maxCoeff(), 1e-9) << steps.transpose();
        for (int k = 0; k < 3; ++k)
            EXPECT_NEAR(found.lattice_steps[k], steps[k] < 0.01 ? 0 : steps[k], 1e-9) << steps.transpose();
    }
    Points far_north = torus();
    for (Point& p : far_north)
        p = (10 * p + Point(5e5, 5e6, 100)).cast<float>().cast<double>();
    EXPECT_EQ(find_in_order(far_north).lattice_steps, Vector(0, 0.5, 0));
    EXPECT_FALSE(find_in_order(shapes::rounded(torus(), Vector(1e-9, 0.005, 1e-9)))); // finer than the points are dense
    Points slices;                                                                    // of a sphere, exact
    for (int level = -9; level <= 9; ++level)
        for (int k = 0; k < 600; ++k)
        {
            const double z = 0.1 * level, radius = std::sqrt(1 - z * z), angle = k * EIGEN_PI / 300;
            slices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
        }
    EXPECT_FALSE(find_in_order(slices));
    Points sheets; // above each other
    for (const Point& p : shapes::sphere(12'000, 1, 4).points)
        sheets.emplace_back(p.x(), p.y(), 0.05 * std::round(2.5 * p.z() + 2.5));
    for (Point& p : sheets)
        p.head<2>() = Eigen::Vector2d(std::fmod(7 * p.x() + 10, 1), std::fmod(7 * p.y() + 10, 1));
    EXPECT_FALSE(find_in_order(sheets));
}

TEST(FindRounding, FindsNoneWhereItTellsNothing)
{
    EXPECT_FALSE(find_in_order(torus()));
    EXPECT_FALSE(find_in_order(shapes::rounded(torus(), Vector::Constant(0.002)))); // far below the spacing
    EXPECT_FALSE(find_in_order(shapes::lattice_cube(20)));                          // flat as it is
    EXPECT_FALSE(find_in_order(hills(60)));                                         // heights take any value
    EXPECT_FALSE(find_in_order(shapes::rounded(shapes::sphere(150, 1, 1).points, Vector::Constant(0.2))));
    Points two_axes = shapes::rounded(torus(), Vector(0.05, 0.05, 1e-7));
    EXPECT_FALSE(find_in_order(two_axes));
    Points far_apart = shapes::rounded(torus(), Vector::Constant(0.05)), warped = far_apart;
    for (Point& p : far_apart)
        p = (20 * p).array().pow(17); // whole numbers that leave most out
    EXPECT_FALSE(find_in_order(far_apart));
    for (Point& p : warped)
        p += 0.01 * (20 * p).array().sin().matrix();
    EXPECT_FALSE(find_in_order(warped));
    Points three_cubes;
    for (const Point& p : shapes::lattice_cube(8))
        for (int axis = 0; axis < 3; ++axis)
            three_cubes.push_back(p + 8 * Vector::Unit(axis));
    EXPECT_FALSE(find_in_order(shapes::rounded(three_cubes, Vector::Ones())));
    Points one_off = shapes::rounded(torus(), Vector::Constant(0.05));
    one_off[100].x() += 0.017;
    EXPECT_EQ(find_in_order(one_off).lattice_steps.x(), 0); // but the other axes are
}

TEST(FindRounding, FindsACameraWithCoarseDepths)
{
    const Rounding found = find_in_order(shapes::depth_frame(120, 0.02, 3).points);
    EXPECT_EQ(found.lattice_step, 0);
    EXPECT_TRUE(found.camera);
}

TEST(FindRounding, DitheredPointsStayInTheirCells)
{
    const Vector steps(0.03, 0.03, 0.1);
    const Points voxels = shapes::rounded(torus(), steps);
    Rounding lattice;
    lattice.lattice_steps = steps;
    const Points dithered = lattice.dither(voxels);
    Vector sum = Vector::Zero(), squares = Vector::Zero();
    for (std::size_t i = 0; i < voxels.size(); ++i)
    {
        const Vector moved = (dithered[i] - voxels[i]).cwiseQuotient(steps);
        ASSERT_LE(moved.cwiseAbs().maxCoeff(), 0.5);
        sum += moved;
        squares += moved.cwiseAbs2();
    }
    EXPECT_LT((sum / double(voxels.size())).norm(), 0.02);
    EXPECT_LT((squares / double(voxels.size()) - Vector::Constant(1.0 / 12)).norm(), 0.01);
}
