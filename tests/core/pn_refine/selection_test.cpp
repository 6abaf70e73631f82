#include "one_thread.h"

#include "filter_pn_refine/refine.h"

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace
{

using namespace recon;

TEST(Selection, EdgesGetPointsOnlyWhereSomethingIsRefined)
{
    const OrientedSamples cube = shapes::box(1350, Vector(2, 2, 2), 5);
    const Point corner(1, 1, 1);
    std::vector<double> distances;
    for (const Point& p : cube.points)
        distances.push_back((p - corner).norm());
    std::vector<double> sorted = distances;
    std::nth_element(sorted.begin(), sorted.begin() + 48, sorted.end());
    PnRefineHints hints;
    for (const double d : distances)
        hints.is_refined.push_back(d < sorted[48]);
    const PnRefinement refined = refine_points(cube, one_thread(3), hints);
    EXPECT_GT(refined.crease_points, 10);
    EXPECT_GT(refined.points.size(), 500u);
    const double spacing = std::sqrt(24.0 / 1350);
    for (const Point& p : refined.points)
        EXPECT_LT((p - corner).norm(), sorted[48] + 4 * spacing);
}

TEST(Selection, HolesBesideFrozenPointsStayOpen)
{
    const OrientedSamples sphere = shapes::sphere(3500, 1, 2);
    OrientedSamples open;
    PnRefineHints hints;
    for (const Point& p : sphere.points)
        if (std::abs(p.z()) < 0.9)
        {
            open.points.push_back(p);
            open.normals.push_back(p.normalized());
            hints.is_refined.push_back(p.z() > 0);
        }
    PnRefineOptions options = one_thread(2);
    options.hole_radius = 0.44;
    const PnRefinement refined = refine_points(open, options, hints);
    EXPECT_GT(refined.hole_points, 50);
    for (const Point& p : refined.points)
        EXPECT_GT(p.z(), -0.2);
    options.hole_radius = 0;
    for (char& is_refined : hints.is_refined)
        is_refined = 0;
    EXPECT_TRUE(refine_points(open, options, hints).points.empty());
}

TEST(Selection, FrozenPointsKeepTheirNormals)
{
    OrientedSamples torus = shapes::torus(5000, 1, 0.4, 3);
    PnRefineHints hints;
    std::vector<int> expected;
    for (int i = 0; i < 5000; ++i)
    {
        hints.is_refined.push_back(torus.points[std::size_t(i)].x() > 0);
        if (i % 50 != 17)
            continue;
        torus.normals[std::size_t(i)] *= -1;
        if (hints.is_refined.back())
            expected.push_back(i);
    }
    EXPECT_EQ(refine_points(torus, one_thread(1), hints).turned_normals, expected);
}

} // namespace
