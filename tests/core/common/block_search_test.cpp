#include <recon/search/block_search.h>
#include <recon/search/spatial_order.h>

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numeric>
#include <string>

using namespace recon;

namespace
{

Points in_spatial_order(const Points& points)
{
    Points sorted;
    for (const int i : order_spatially(points).order)
        sorted.push_back(points[i]);
    return sorted;
}

void compare_with_brute_force(const Points& points, const Points& queries, const std::string& what)
{
    const BlockSearch search(points);
    for (const Point& query : queries)
    {
        std::vector<int> order(points.size());
        std::iota(order.begin(), order.end(), 0);
        const auto squared = [&](int i)
        {
            const Vector d = points[i] - query;
            return d.x() * d.x() + d.y() * d.y() + d.z() * d.z();
        };
        std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return squared(a) < squared(b); });
        for (const int k : {1, 7, 40})
        {
            std::vector<int> found(k, -1);
            std::vector<double> distances(k);
            for (double reach : {0.0, 1e-5, 100.0})
            {
                const int count = search.nearest(query, k, found.data(), distances.data(), reach);
                ASSERT_EQ(count, std::min<int>(k, int(points.size()))) << what;
                for (int i = 0; i < count; ++i)
                    EXPECT_NEAR(distances[i], squared(order[i]), 1e-12 * (1 + squared(order[i]))) << what;
                EXPECT_GE(reach, std::sqrt(distances[count - 1])) << what;
            }
        }
        const int middle = order[order.size() / 2];
        const double radius = std::sqrt(squared(middle)) * (1 + 1e-12);
        std::vector<int> within, expected;
        search.within(query, radius, within);
        for (int i = 0; i < int(points.size()); ++i)
            if (squared(i) <= radius * radius)
                expected.push_back(i);
        EXPECT_EQ(within, expected) << what;
        const int count = int(expected.size());
        EXPECT_TRUE(search.has_within(query, radius, count)) << what;
        EXPECT_FALSE(search.has_within(query, radius, count + 1)) << what;
    }
}

} // namespace

TEST(BlockSearch, AgreesWithBruteForce)
{
    const Points queries = shapes::with_noise(shapes::sphere(30, 1, 8).points, 0.3, 9);
    for (const int n : {1, 7, 8, 9, 64, 65, 700, 5000})
    {
        const Points torus = shapes::torus(n, 1, 0.3, 7).points;
        compare_with_brute_force(in_spatial_order(torus), queries, "sorted " + std::to_string(n));
        compare_with_brute_force(torus, queries, "unsorted " + std::to_string(n));
    }
}

TEST(BlockSearch, PutsEqualPointsInOrder)
{
    const BlockSearch search(Points(100, Point(1, 2, 3)));
    int found[10];
    double squared[10];
    double reach = 0;
    ASSERT_EQ(search.nearest(Point(0, 2, 3), 10, found, squared, reach), 10);
    for (int k = 0; k < 10; ++k)
    {
        EXPECT_EQ(found[k], k);
        EXPECT_EQ(squared[k], 1);
    }
}

// Where a whole leaf is one point, and where the cloud's own spacing says nothing, a first guess of the distance fails.
TEST(BlockSearch, SearchesOnBeyondRepeatedPointsAndFromObjectsFarApart)
{
    Points points = shapes::sphere(300, 1, 5).points;
    points.insert(points.end(), 24, Point(0, 0, 1));
    for (const Point& p : shapes::sphere(20, 1e-4, 6).points)
        points.push_back(p + Point(1e5, 0, 0));
    compare_with_brute_force(in_spatial_order(points), {Point(0, 0, 1), Point(1e5, 0, 0), Point(3e4, 0, 0)}, "sorted");
    compare_with_brute_force(points, {Point(0, 0, 1), Point(1e5, 0, 0), Point(3e4, 0, 0)}, "unsorted");
}

// Nine tenths of the points in a thousandth of the extent: boxes of both kinds of points overlap all others, and a
// guess made for one kind finds all or nothing of the other. Took 280 times as long as on an even sphere.
TEST(BlockSearch, IsFastWhereSpacingsAreMixed)
{
    const Points sphere = shapes::sphere(20000, 1, 7).points;
    Points mixed = sphere;
    for (std::size_t i = 0; i < mixed.size(); ++i)
        if (i % 10 > 0)
            mixed[i] *= 1e-3;
    const auto measure = [](const Points& points)
    {
        const BlockSearch search(points);
        const std::clock_t begin = std::clock();
        double sum = 0;
        for (const Point& p : points)
        {
            int nearest[2];
            double squared[2];
            search.nearest(p, 2, nearest, squared);
            sum += squared[1];
        }
        EXPECT_GT(sum, 0);
        return double(std::clock() - begin);
    };
    const Points even = in_spatial_order(sphere), uneven = in_spatial_order(mixed);
    EXPECT_LT(measure(uneven), 40 * measure(even));
}

TEST(BlockSearch, HasNoNeighboursAmongNoPoints)
{
    const BlockSearch none, empty{Points{}};
    for (const BlockSearch* search : {&none, &empty})
    {
        std::vector<int> within(3);
        search->within(Point::Zero(), 1e300, within);
        EXPECT_TRUE(within.empty());
        EXPECT_FALSE(search->has_within(Point::Zero(), 1e300, 1));
        within.resize(1);
        double squared = 0, reach = 0;
        EXPECT_EQ(search->nearest(Point::Zero(), 1, within.data(), &squared, reach), 0);
    }
}

TEST(BlockSearch, FindsAllWithinAnEndlessRadius)
{
    const Points points = shapes::sphere(77, 1, 3).points;
    std::vector<int> within;
    BlockSearch(points).within(Point::Zero(), 1e300, within);
    EXPECT_EQ(within.size(), points.size());
}

// Large enough for several threads on three levels.
TEST(BlockSearch, IsBuiltTheSameByManyThreads)
{
    const Points points = in_spatial_order(shapes::sphere(150'000, 1, 3).points);
    const BlockSearch by_one(points), by_many(points, 3);
    for (std::size_t i = 0; i < points.size(); i += 151)
    {
        std::vector<int> one, many;
        by_one.within(points[i], 0.02, one);
        by_many.within(points[i], 0.02, many);
        ASSERT_GT(one.size(), 5u);
        ASSERT_EQ(one, many);
    }
}
