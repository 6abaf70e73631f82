#include "filter_amls/cells/cell_sides.h"

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace recon;

namespace
{

constexpr double width = 0.1, sigma = 0.02;

/// Anchors half a width apart, and cells near them.
struct Scene
{
    std::vector<Anchor> anchors;
    Cells cells;
    Vectors normals; ///< Of the cells.

    void add_sheet(double height, double side)
    {
        for (double x = -1; x <= 1; x += 0.5 * width)
            for (double y = -1; y <= 1; y += 0.5 * width)
                anchors.push_back({Point(x, y, height), Vector(0, 0, side), {}, 10, width});
    }
    void add_cell(const Point& mean, const Vector& normal)
    {
        cells.means.push_back(mean);
        cells.counts.push_back(1);
        cells.scales.push_back({sigma, 1000, width});
        normals.push_back(normal.normalized());
    }
    Vectors follow(int threads = 1) const
    {
        Points positions;
        for (const Anchor& a : anchors)
            positions.push_back(a.position);
        Vectors result = normals;
        follow_anchors(cells, anchors, BlockSearch(positions), result, threads);
        return result;
    }
};

} // namespace

TEST(FollowAnchors, CellsInTheTailsOfTheNoiseTakeTheSideOfTheSurface)
{
    Scene scene;
    scene.add_sheet(0, 1);
    scene.add_cell({0.02, 0.01, 2.5 * sigma}, {1, 0, -0.1});
    scene.add_cell({0.4, -0.3, -2 * sigma}, {0, 0, -1});
    scene.add_cell({-0.4, 0.2, 0}, {0.2, 0, 1});
    const Vectors found = scene.follow();
    EXPECT_GT(found[0].z(), 0.99);
    EXPECT_GT(found[1].z(), 0.99);
    EXPECT_EQ(found[2], scene.normals[2]) << "one that agrees is better than a mean over all around";
}

TEST(FollowAnchors, CellsAtARimTakeTheSideOfWhatPassesThem)
{
    // A wedge whose sides meet at z = 0; the cells' normals lie along its edge's bisector, inward.
    Scene scene;
    const Vector right = Vector(1, 0, 0.6).normalized(), left = Vector(-1, 0, 0.6).normalized();
    for (double t = 0.2 * width; t < 1; t += 0.5 * width)
        for (double y = -1; y <= 1; y += 0.5 * width)
        {
            scene.anchors.push_back({Point(0.6 * t, y, -t), right, {}, 10, width});
            scene.anchors.push_back({Point(-0.6 * t, y, -t), left, {}, 10, width});
        }
    scene.add_cell({0, 0, 0.3 * sigma}, {0.1, 0, -1});
    EXPECT_GT(scene.follow()[0].z(), 0.9);
}

TEST(FollowAnchors, CellsBetweenSheetsKeepTheirSide)
{
    Scene scene;
    scene.add_sheet(2 * sigma, 1);
    scene.add_sheet(-2 * sigma, -1);
    scene.add_cell({0.1, 0, 0}, {0, 0, 1});
    scene.add_cell({-0.3, 0.1, 0}, {0, 0, -1});
    scene.add_cell({0.3, 0.3, 2.5 * sigma}, {1, 0.1, 0});
    scene.add_cell({0.2, -0.3, 0.2 * sigma}, {0, 0, -1});
    const Vectors found = scene.follow();
    EXPECT_EQ(found[0], scene.normals[0]);
    EXPECT_EQ(found[1], scene.normals[1]);
    EXPECT_GT(found[2].z(), 0.99) << "the nearer sheet is heard";
    EXPECT_GT(found[3].z(), 0.99) << "be it by little";
}

TEST(FollowAnchors, KeepNormalsWhereNoAnchorIsNearAndDoNotDependOnThreads)
{
    Scene scene;
    scene.add_sheet(0, 1);
    scene.add_cell({5, 5, 5}, {1, 0, 0});
    shapes::Random random(7);
    std::normal_distribution<double> normal;
    const auto draw = [&] { return normal(random); };
    for (int i = 0; i < 500; ++i)
    {
        const Vector facing = shapes::draw_vector(draw);
        scene.add_cell(Vector(0.3, 0.3, sigma).cwiseProduct(shapes::draw_vector(draw)), facing);
    }
    const Vectors found = scene.follow();
    EXPECT_EQ(found[0], scene.normals[0]);
    EXPECT_EQ(scene.follow(3), found);
}
