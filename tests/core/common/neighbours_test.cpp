#include <recon/search/neighbours.h>

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

using namespace recon;

TEST(NeighbourSearch, AgreesWithBruteForce)
{
    const Points points = shapes::torus(500, 1, 0.3, 7).points;
    const NeighbourSearch search(points);
    for (const Point& query : shapes::sphere(50, 1, 8).points)
    {
        std::vector<int> order(points.size());
        std::iota(order.begin(), order.end(), 0);
        const auto squared = [&](int i) { return (points[i] - query).squaredNorm(); };
        std::sort(order.begin(), order.end(), [&](int a, int b) { return squared(a) < squared(b); });

        int found[20];
        double distances[20];
        ASSERT_EQ(search.nearest(query, 20, found, distances), 20);
        for (int k = 0; k < 20; ++k)
            EXPECT_DOUBLE_EQ(distances[k], squared(order[k]));
        EXPECT_EQ(search.nearest(query), order[0]);

        std::vector<int> within;
        search.within(query, std::sqrt(squared(order[30])) * (1 + 1e-14), within);
        EXPECT_EQ(within.size(), 31u);
    }
}

TEST(NeighbourSearch, HasNoNeighboursAmongNoPoints)
{
    const Points none;
    const NeighbourSearch search(none);
    std::vector<int> within(3);
    search.within(Point::Zero(), 1, within);
    EXPECT_TRUE(within.empty());
    EXPECT_EQ(search.nearest(Point::Zero()), -1);
}
