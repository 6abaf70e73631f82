#include "filter_amls/cells/isolated_points.h"

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace recon;

namespace
{

int count_marks(const Points& points, int threads = 2)
{
    const std::vector<char> marks = mark_isolated_points(points, threads);
    return int(std::count(marks.begin(), marks.end(), 1));
}

} // namespace

TEST(IsolatedPoints, ScatteredOnesAreMarkedAndNoOthers)
{
    const Points torus = shapes::torus(6000, 1, 0.3, 3).points;
    EXPECT_EQ(count_marks(torus), 0);
    Points points = torus;
    for (const Point& p : shapes::scattered(400, {4, 4, 4}, 5))
        if (shapes::distance_to_torus(p, 1, 0.3) > 0.2)
            points.push_back(p);
    points.push_back(points.back()); // twice: both
    const std::vector<char> marks = mark_isolated_points(points, 2);
    for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_EQ(marks[i] != 0, i >= torus.size()) << points[i].transpose();
    EXPECT_EQ(marks, mark_isolated_points(points, 1));
}

TEST(IsolatedPoints, OneIsMarkedToo)
{
    for (const double off : {0.3, 3.0, 1e5})
    {
        Points points = shapes::sphere(3000, 1, 7).points;
        points.emplace_back(0, 0, 1 + off);
        const std::vector<char> marks = mark_isolated_points(points, 1);
        EXPECT_EQ(std::count(marks.begin(), marks.end(), 1), 1) << off;
        EXPECT_EQ(marks.back(), 1) << off;
    }
}

TEST(IsolatedPoints, StraysNearTheSurfaceAreMarkedWhereThereAreOutliers)
{
    const Points torus = shapes::torus(6000, 1, 0.3, 3).points;
    const double spacing = std::sqrt(4 * EIGEN_PI * EIGEN_PI * 0.3 / double(torus.size()));
    const OrientedSamples under = shapes::torus(60, 1, 0.3, 8);
    Points points = torus;
    for (std::size_t i = 0; i < under.points.size(); ++i)
        points.push_back(under.points[i] + 1.2 * spacing * under.normals[i]);
    const std::size_t near = points.size();
    EXPECT_EQ(count_marks(points), 0) << "who knows what they are";
    for (const Point& p : shapes::scattered(100, {4, 4, 4}, 5))
        points.push_back(p);
    const std::vector<char> marks = mark_isolated_points(points, 2);
    const auto from = [&](std::size_t i) { return marks.begin() + std::ptrdiff_t(i); };
    EXPECT_EQ(std::count(from(0), from(torus.size()), 1), 0);
    EXPECT_GE(std::count(from(torus.size()), from(near), 1), 55);
    EXPECT_EQ(marks, mark_isolated_points(points, 1));
}

TEST(IsolatedPoints, CoarseAndUnevenCloudsHaveNone)
{
    for (unsigned seed = 1; seed <= 5; ++seed)
        for (const int n : {120, 600, 3500})
        {
            EXPECT_EQ(count_marks(shapes::torus(n, 1, 0.3, seed).points), 0) << n;
            EXPECT_EQ(count_marks(shapes::box(n, {3, 2, 1}, seed).points), 0) << n;
        }
    Points uneven = shapes::sphere(300, 1, 3).points;
    for (const Point& p : shapes::sphere(30'000, 1, 4).points)
        if (p.z() > 0)
            uneven.push_back(p);
    EXPECT_EQ(count_marks(uneven), 0);
}

TEST(IsolatedPoints, CloudsWithoutVolumeAreNoTrouble)
{
    EXPECT_TRUE(mark_isolated_points({}, 1).empty());
    EXPECT_EQ(count_marks(Points(500, Point(1, 2, 3))), 0);
    Points line, plane;
    for (int i = 0; i < 400; ++i)
    {
        line.emplace_back(i, 0, 0);
        plane.emplace_back(i % 20, i / 20, 0);
    }
    EXPECT_EQ(count_marks(line), 0);
    EXPECT_EQ(count_marks(plane), 0);
    line.emplace_back(1e4, 0, 0);
    plane.emplace_back(1e3, 0, 0);
    EXPECT_LE(count_marks(line), 1);
    EXPECT_LE(count_marks(plane), 1);
}
