#include "filter_amls/cells/scattered_points.h"
#include "filter_amls/cells/surface_cells.h"

#include "tests/shapes.h"

#include <recon/search/spatial_order.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace recon;

namespace
{

/// Points in spatial order, and which of them are scattered.
struct Scene
{
    Points points;
    std::vector<char> is_scattered;
    std::vector<int> known; ///< Every tenth of these.
};

Scene make_scene(Points surface, const Points& scattered)
{
    const std::size_t genuine = surface.size();
    surface.insert(surface.end(), scattered.begin(), scattered.end());
    Scene scene;
    int count = 0;
    for (const int i : order_spatially(surface).order)
    {
        if (std::size_t(i) >= genuine && count++ % 10 == 0)
            scene.known.push_back(int(scene.points.size()));
        scene.points.push_back(surface[std::size_t(i)]);
        scene.is_scattered.push_back(std::size_t(i) >= genuine);
    }
    return scene;
}

double distance(const Point& p)
{
    return shapes::distance_to_torus(p, 1, 0.35);
}

} // namespace

TEST(ScatteredPoints, ATenthOfThemTellsTheOthers)
{
    for (const double noise : {0.0, 0.02})
    {
        const Scene scene = make_scene(shapes::with_noise(shapes::torus(20'000, 1, 0.35, 3).points, noise, 4),
                                       shapes::scattered(20'000, {4, 4, 2}, 5));
        const BlockSearch search(scene.points);
        const std::vector<int> found = with_scattered_points(scene.points, search, scene.known, 1);
        EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
        EXPECT_TRUE(std::includes(found.begin(), found.end(), scene.known.begin(), scene.known.end()));
        EXPECT_EQ(found, with_scattered_points(scene.points, search, scene.known, 3));
        int mistaken = 0, far = 0, far_found = 0;
        for (const int i : found)
            mistaken += !scene.is_scattered[std::size_t(i)];
        for (std::size_t i = 0; i < scene.points.size(); ++i)
            far += distance(scene.points[i]) > 0.15;
        for (const int i : found)
            far_found += distance(scene.points[std::size_t(i)]) > 0.15;
        EXPECT_LT(mistaken, 40) << noise;
        EXPECT_GT(far, 10'000) << noise;
        EXPECT_GT(far_found, 0.98 * far) << noise;
    }
}

TEST(ScatteredPoints, SparseSheetsAreNone)
{
    // As far from each other as the scattered ones, among these.
    Points surface = shapes::torus(20'000, 1, 0.35, 3).points;
    const std::size_t dense = surface.size();
    for (int i = -20; i < 20; ++i)
        for (int k = -20; k < 20; ++k)
            surface.emplace_back(0.1 * i, 0.1 * k, 1.2);
    const Points scattered = shapes::scattered(4'000, {4, 4, 3}, 5);
    const Scene scene = make_scene(surface, scattered);
    const std::vector<int> found = with_scattered_points(scene.points, BlockSearch(scene.points), scene.known, 2);
    int sheet_found = 0, scattered_found = 0;
    for (const int i : found)
        (scene.is_scattered[std::size_t(i)] ? scattered_found : sheet_found) += 1;
    EXPECT_LT(sheet_found, 0.15 * double(surface.size() - dense));
    EXPECT_GT(scattered_found, 0.6 * double(scattered.size()));
}

TEST(ScatteredPoints, WhatIsFarFromTheKnownOnesIsNone)
{
    // A bush as sparse as what is scattered elsewhere.
    Points surface = shapes::torus(20'000, 1, 0.35, 3).points;
    for (const Point& p : shapes::scattered(500, {2, 2, 2}, 6))
        surface.push_back(p + Vector(9, 0, 0));
    const Scene scene = make_scene(surface, shapes::scattered(3'000, {4, 4, 3}, 5));
    const std::vector<int> found = with_scattered_points(scene.points, BlockSearch(scene.points), scene.known, 2);
    EXPECT_GT(found.size(), 2'000u);
    EXPECT_TRUE(std::none_of(found.begin(), found.end(), [&](int i) { return scene.points[std::size_t(i)].x() > 7; }));
}

TEST(SurfaceCells, OutliersAreFoundWhateverTheirShare)
{
    // The few would cost some of the sparse half, were more like them looked for.
    for (const double share : {0.05, 1.0})
    {
        Points points;
        shapes::Random random(7);
        for (const Point& p : shapes::with_noise(shapes::sphere(20'000, 1, 3).points, share < 1 ? 0 : 0.03, 4))
            if (p.z() > 0 || share == 1 || shapes::uniform(random) < 0.02)
                points.push_back(p);
        const Scene scene = make_scene(points, shapes::scattered(int(share * double(points.size())), {3, 3, 3}, 5));
        const UnitFrame frame(scene.points);
        const Points scaled = frame.to_unit(scene.points);
        PhaseTimes times;
        const SurfaceCells made = make_surface_cells(scaled, BlockSearch(scaled), 0, {}, 2, times);
        int far = 0, found = 0, mistaken = 0;
        for (std::size_t i = 0; i < scene.points.size(); ++i)
            far += std::abs(scene.points[i].norm() - 1) > 0.3;
        for (const int i : list_outliers(made.cells, made.normals))
        {
            mistaken += !scene.is_scattered[std::size_t(i)];
            found += std::abs(scene.points[std::size_t(i)].norm() - 1) > 0.3;
        }
        EXPECT_GT(found, 0.98 * far) << share;
        EXPECT_LT(mistaken, share < 1 ? 40 : 100) << share;
    }
}

TEST(ScatteredPoints, TooFewKnownTellNothing)
{
    const Scene scene = make_scene(shapes::sphere(1'000, 1, 3).points, shapes::scattered(100, {4, 4, 4}, 5));
    const BlockSearch search(scene.points);
    EXPECT_EQ(with_scattered_points(scene.points, search, scene.known, 1), scene.known);
    EXPECT_TRUE(with_scattered_points(scene.points, search, {}, 1).empty());
    EXPECT_TRUE(with_scattered_points({}, {}, {}, 1).empty());
}
