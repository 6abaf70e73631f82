#include <recon/crust/lids.h>

#include "tests/checks.h"
#include "tests/shapes.h"

#include <recon/mesh/crust_mesh.h>
#include <recon/mesh/mismatch.h>
#include <recon/progress.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

using namespace recon;

namespace
{

/// A square tray in a unit frame, its walls two spacings thick. The normals of the inner faces point into the walls, as
/// of a tray taken for full.
struct Tray
{
    Points samples;
    Vectors normals;
};

constexpr int side = 36, height = 16, wall = 2;
constexpr double spacing = 0.5 / side;

Tray make_tray()
{
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> jitter(-0.2, 0.2);
    Tray result;
    const auto add = [&](double x, double y, double z, const Vector& normal)
    {
        const Vector moved =
            Vector(jitter(random), jitter(random), jitter(random)).cwiseProduct(Vector::Ones() - normal.cwiseAbs());
        result.samples.push_back(spacing * (Point(x, y, z) + moved));
        result.normals.push_back(normal);
    };
    const auto add_faces = [&](int from, int floor)
    {
        const int to = side - from;
        for (int i = from; i <= to; ++i)
            for (int j = from; j <= to; ++j)
                add(i, j, floor, -Vector::UnitZ());
        for (int i = from; i <= to; ++i)
            for (int k = floor + 1; k <= height; ++k)
            {
                add(i, from, k, -Vector::UnitY());
                add(i, to, k, Vector::UnitY());
                add(from, i, k, -Vector::UnitX());
                add(to, i, k, Vector::UnitX());
            }
    };
    add_faces(0, 0);
    add_faces(wall, wall);
    for (Point& p : result.samples)
        p -= Vector(0.25, 0.25, 0);
    return result;
}

LabelledBalls label(const Tray& tray, std::vector<int> opened = {})
{
    PhaseTimes times;
    BallLabellingOptions options;
    options.opened = std::move(opened);
    return label_polar_balls(tray.samples, tray.normals, options, times);
}

double measure_volume(const LabelledBalls& labelled)
{
    return checks::examine_mesh(triangulate_polygons(list_crust_polygons(labelled.regular, labelled.labels))).volume;
}

} // namespace

TEST(Lids, BallsUnderTheMouthOfAFilledTrayAreFoundAndOpenIt)
{
    const Tray tray = make_tray();
    const LabelledBalls filled = label(tray);
    const std::vector<int> under = list_balls_under_lids(tray.samples, filled);
    ASSERT_FALSE(under.empty());
    for (const int ball : under)
    {
        const Ball& found = filled.kept.balls[ball];
        EXPECT_EQ(filled.labels[ball], Side::inner);
        EXPECT_LT(std::max(std::abs(found.centre.x()), std::abs(found.centre.y())), 0.25); // within the walls
        EXPECT_GT(found.centre.z(), 0);
    }
    constexpr double full = side * side * height,
                     hollow = full - (side - 2 * wall) * (side - 2 * wall) * (height - wall);
    EXPECT_GT(measure_volume(filled) / std::pow(spacing, 3), 0.7 * full);
    EXPECT_NEAR(measure_volume(label(tray, under)) / std::pow(spacing, 3), hollow, 0.1 * hollow);
}

TEST(Lids, AWholeBodyHasNone)
{
    PhaseTimes times;
    const OrientedSamples sphere = shapes::sphere(3000, 0.4, 5);
    const LabelledBalls labelled = label_polar_balls(sphere.points, sphere.normals, {}, times);
    EXPECT_TRUE(list_balls_under_lids(sphere.points, labelled).empty());
}

// Of a forest (power crust, AMLS), of noise as large as the spacing, of a street; of cups of five samples a spot, of
// one.
TEST(Lids, LessNoiseIsGivenUpWhereItFindsNoWalls)
{
    EXPECT_TRUE(finds_no_walls({0.129, 0.109}, {0.117, 0.107}));
    EXPECT_TRUE(finds_no_walls({0.206, 0.030}, {0.086, 0.044}));
    EXPECT_TRUE(finds_no_walls({0.300, 0.0025}, {0.208, 0.0133}));
    EXPECT_TRUE(finds_no_walls({0.0195, 0.0219}, {0.0166, 0.0236}));
    EXPECT_FALSE(finds_no_walls({0.0192, 0.0489}, {0.0168, 0.0570}));
    EXPECT_FALSE(finds_no_walls({0.235, 0.0423}, {0.024, 0.0592}));
    EXPECT_FALSE(finds_no_walls({0.049, 0.0559}, {0.020, 0.0624}));
    EXPECT_FALSE(finds_no_walls({0.484, 0.0005}, {0.198, 0.0316}));
    EXPECT_FALSE(finds_no_walls({0.007, 0.0006}, {0.008, 0.0228}));
}
