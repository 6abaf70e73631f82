#include <recon/search/spatial_order.h>

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace recon;

TEST(OrderSpatially, ListsDistinctPointsOnceWithTheirFirstIndex)
{
    Points points = shapes::sphere(300, 1, 1).points;
    points.insert(points.end(), points.begin(), points.begin() + 100);
    const SpatialOrder spatial = order_spatially(points);
    ASSERT_EQ(spatial.order.size(), 300u);
    EXPECT_EQ(*std::max_element(spatial.order.begin(), spatial.order.end()), 299);
    for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_EQ(points[spatial.order[spatial.representative[i]]], points[i]);
}

TEST(OrderSpatially, DoesNotDependOnTheOrderOfTheInput)
{
    Points points = shapes::torus(1000, 1, 0.3, 2).points;
    const auto sorted = [](const Points& p)
    {
        Points result;
        for (int i : order_spatially(p).order)
            result.push_back(p[i]);
        return result;
    };
    const Points before = sorted(points);
    std::reverse(points.begin(), points.end());
    EXPECT_EQ(sorted(points), before);
}

TEST(OrderSpatially, KeepsNeighboursTogether)
{
    const Points points = shapes::sphere(4096, 1, 3).points;
    const SpatialOrder spatial = order_spatially(points);
    double path = 0, unsorted = 0;
    for (std::size_t i = 1; i < points.size(); ++i)
    {
        path += (points[spatial.order[i]] - points[spatial.order[i - 1]]).norm();
        unsorted += (points[i] - points[i - 1]).norm();
    }
    EXPECT_LT(path, 0.1 * unsorted);
    // A stray point far away, which leaves all others to one cell of the curve.
    Points with_stray = points;
    with_stray.push_back(Point::Constant(1e9));
    const SpatialOrder same = order_spatially(with_stray);
    double path_beside = 0;
    for (std::size_t i = 1; i < points.size(); ++i)
        path_beside += (with_stray[same.order[i]] - with_stray[same.order[i - 1]]).norm();
    EXPECT_LT(path_beside, 0.1 * unsorted);
}

TEST(OrderSpatially, TakesEmptyAndEqualPoints)
{
    EXPECT_TRUE(order_spatially({}).order.empty());
    EXPECT_EQ(order_spatially(Points(7, Point(1, 1, 1))).order, std::vector<int>{0});
}

TEST(OrderInput, TakesTheEndOfMeridiansForOnePoint)
{
    for (const double radius : {1e-16, 1e-8, 1e-6})
    {
        Points points = shapes::sphere(3000, 1, 1).points;
        for (int i = 0; i < 100; ++i)
            points.emplace_back(5 + radius * std::cos(0.0628 * i), radius * std::sin(0.0628 * i), 1);
        const SpatialOrder spatial = order_input(points);
        EXPECT_EQ(spatial.order.size(), 3001u) << radius;
        for (std::size_t i = 0; i < points.size(); ++i)
            EXPECT_LE((points[spatial.order[spatial.representative[i]]] - points[i]).norm(), 2 * radius);
        EXPECT_EQ(order_spatially(points).order.size(), 3100u) << radius;
    }
}

// Objects may be small beside the distance to others, and dense parts go on beyond a spot.
TEST(OrderInput, KeepsSmallObjectsAndDenseParts)
{
    Points points = shapes::sphere(1000, 1, 1).points;
    for (const Point& p : shapes::sphere(1000, 1e-8, 2).points)
        points.push_back(p + Point(5, 0, 0));
    EXPECT_EQ(order_input(points).order.size(), points.size());
    points = shapes::sphere(3000, 1, 1).points;
    for (int i = 1; i < 100; ++i)
        points.emplace_back(5 + std::pow(0.8, i), 0, 0); // down to 2.6e-10
    EXPECT_GT(order_input(points).order.size(), points.size() - 40);
    EXPECT_TRUE(order_input({}).order.empty());
}

// As of one scan twice, written with other digits.
TEST(OrderInput, TakesTwinsForOnePoint)
{
    const Points once = shapes::sphere(3000, 1, 1).points;
    const auto with_twins = [&](double apart, int copies)
    {
        Points points = once;
        for (int k = 0; k < copies; ++k)
            for (const Point& p : shapes::with_noise(once, apart, std::uint64_t(k) + 2))
                points.push_back(p);
        return points;
    };
    for (const double apart : {1e-6, 1e-5})
        for (const int copies : {1, 4})
        {
            const Points points = with_twins(apart, copies);
            const SpatialOrder spatial = order_input(points);
            EXPECT_NEAR(double(spatial.order.size()), 3000, 10) << apart << " " << copies;
            for (std::size_t i = 0; i < points.size(); ++i)
                EXPECT_LE((points[spatial.order[spatial.representative[i]]] - points[i]).norm(), 12 * apart);
        }
    for (const double noise : {1e-3, 3e-4}) // some are as near as twins, others farther
        EXPECT_EQ(order_input(with_twins(noise, 1)).order.size(), 6000u) << noise;
    Points few(once.begin(), once.begin() + 400), many_objects = once;
    few.insert(few.end(), few.begin(), few.end());
    for (std::size_t i = 400; i < few.size(); ++i)
        few[i].z() += 1e-5;
    EXPECT_EQ(order_input(few).order.size(), 800u);
    for (int k = 0; k < 100; ++k)
        for (const Point& p : shapes::sphere(20, 1e-5, std::uint64_t(k) + 1).points)
            many_objects.push_back(p + Point(3, 0.1 * k, 0));
    EXPECT_EQ(order_input(many_objects).order.size(), 5000u);
}

TEST(OrderInput, IsTheSameByManyThreads)
{
    Points points = shapes::sphere(50'000, 1, 1).points;
    points.insert(points.end(), points.begin(), points.begin() + 1000);
    points.emplace_back(1e9, 0, 0); // all others in one cell of the curve
    const SpatialOrder by_one = order_input(points, 1), by_many = order_input(points, 3);
    EXPECT_EQ(by_one.order.size(), 50'001u);
    EXPECT_EQ(by_one.order, by_many.order);
    EXPECT_EQ(by_one.representative, by_many.representative);
}

// Squares of such differences are 0: the twins' spot would shrink for ever.
TEST(OrderInput, EndsWhereSquaredDistancesVanish)
{
    Points points = shapes::sphere(2000, 1, 5).points;
    for (std::size_t i = 0; i < 200; ++i)
        points.push_back(points[i] - points[i].cwiseProduct(Point(0, 0, 1)));
    for (std::size_t i = 0; i < 200; ++i)
        points.push_back(points[2000 + i] + Point(0, 0, 1e-170));
    EXPECT_EQ(order_input(points).order.size(), 2200u);
    Points tiny = shapes::sphere(2000, 1, 5).points;
    for (Point& p : tiny)
        p *= 1e-170;
    EXPECT_EQ(order_input(tiny).order.size(), 2000u);
}
