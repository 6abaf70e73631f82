#include <recon/errors.h>
#include <recon/triangulation/power_predicates.h>
#include <recon/triangulation/regular_triangulation.h>
#include <recon/triangulation/remove_sites.h>

#include "tests/shapes.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numeric>
#include <random>
#include <set>

using namespace recon;

namespace
{

Triangulation triangulate(const Points& points, const std::vector<double>& weights = {}, int threads = 1)
{
    std::vector<int> all(points.size());
    std::iota(all.begin(), all.end(), 0);
    return RegularTriangulation(points, weights, all, threads, {}).flatten(points, weights, threads);
}

void expect_same(const Triangulation& a, const Triangulation& b)
{
    ASSERT_EQ(a.cells.size(), b.cells.size());
    EXPECT_EQ(a.finite_cells, b.finite_cells);
    std::size_t different = 0;
    for (std::size_t c = 0; c < a.cells.size(); ++c)
        different += a.cells[c].vertices != b.cells[c].vertices || a.cells[c].neighbours != b.cells[c].neighbours;
    EXPECT_EQ(different, 0u);
    EXPECT_EQ(a.centres, b.centres);
}

std::set<std::array<int, 4>> list_cells(const Triangulation& t)
{
    std::set<std::array<int, 4>> cells;
    for (const auto& cell : t.cells)
        cells.insert(cell.vertices);
    return cells;
}

/// Points with integer coordinates: many on one sphere, line or plane.
Points grid(int side)
{
    Points points;
    for (int x = 0; x < side; ++x)
        for (int y = 0; y < side; ++y)
            for (int z = 0; z < side; ++z)
                points.emplace_back(x, y, z);
    return points;
}

/// Six times the volume of a cell.
double determinant(const Triangulation::Cell& cell, const Points& points)
{
    const Point& origin = points[cell.vertices[0]];
    const Vector a = points[cell.vertices[1]] - origin, b = points[cell.vertices[2]] - origin;
    return a.cross(b).dot(points[cell.vertices[3]] - origin);
}

void expect_neighbours_agree(const Triangulation& t)
{
    std::size_t wrong = 0;
    for (int c = 0; c < int(t.cells.size()); ++c)
        for (int i = 0; i < 4; ++i)
        {
            const auto& beside = t.cells[t.cells[c].neighbours[i]];
            const int back = beside.position_across(c);
            for (int k = 0; k < 4; ++k)
                wrong += (beside.position_of(t.cells[c].vertices[k]) < 4) != (k != i);
            wrong += back == 4 || t.cells[c].position_of(beside.vertices[back]) < 4;
        }
    EXPECT_EQ(wrong, 0u);
}

} // namespace

TEST(RegularTriangulation, IsTheSameForAnyNumberOfThreads)
{
    const Points cloud = shapes::with_noise(shapes::sphere(20'000, 1, 1).points, 0.02, 2);
    std::vector<double> weights;
    for (std::size_t i = 0; i < cloud.size(); ++i)
        weights.push_back(1e-3 * double(i % 5));
    const Points lattice = grid(20);
    const Triangulation delaunay = triangulate(cloud), regular = triangulate(cloud, weights),
                        degenerate = triangulate(lattice);
    for (const int threads : {2, 3, 8})
    {
        expect_same(triangulate(cloud, {}, threads), delaunay);
        expect_same(triangulate(cloud, weights, threads), regular);
        expect_same(triangulate(lattice, {}, threads), degenerate);
    }
}

TEST(RegularTriangulation, DoesNotDependOnTheOrderOfThePoints)
{
    const Points points = shapes::with_noise(shapes::sphere(500, 1, 1).points, 0.1, 2);
    std::vector<int> order(points.size());
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), std::mt19937(1));
    Points shuffled;
    for (const int i : order)
        shuffled.push_back(points[i]);
    const auto sorted_cells = [](const Triangulation& t, const std::vector<int>& names)
    {
        std::set<std::array<int, 4>> cells;
        for (auto cell : t.cells)
        {
            for (int& v : cell.vertices)
                v = v == Triangulation::infinite || names.empty() ? v : names[v];
            std::sort(cell.vertices.begin(), cell.vertices.end());
            cells.insert(cell.vertices);
        }
        return cells;
    };
    EXPECT_EQ(sorted_cells(triangulate(shuffled), order), sorted_cells(triangulate(points), {}));
}

TEST(RegularTriangulation, FillsALatticeOnce)
{
    const Points points = grid(12);
    const Triangulation t = triangulate(points);
    expect_neighbours_agree(t);
    double sum = 0, smallest = 1;
    std::set<int> used;
    for (int c = 0; c < t.finite_cells; ++c)
    {
        const auto& v = t.cells[c].vertices;
        used.insert(v.begin(), v.end());
        sum += determinant(t.cells[c], points);
        smallest = std::min(smallest, determinant(t.cells[c], points));
        // Integers: exact. Every cell lies in one cube, or a fellow corner of its sphere would lie inside.
        EXPECT_EQ((t.centres[c] - points[v[0]]).squaredNorm(), 0.75);
    }
    EXPECT_EQ(sum, 6 * 11 * 11 * 11);
    EXPECT_EQ(smallest, 1); // positively oriented, none flat
    EXPECT_EQ(used.size(), points.size());
}

TEST(RegularTriangulation, HidesLightSitesAndKeepsTheHeaviestOfEqualOnes)
{
    Points points = shapes::with_noise(shapes::sphere(200, 1, 1).points, 0.1, 2);
    std::vector<double> weights(points.size(), 0.01);
    points.insert(points.end(), {points[0], points[1], Point(0.4, 0, 0), Point(0.41, 0, 0)});
    weights.insert(weights.end(), {0.02, 0.005, 0.2, 0.01});
    std::set<int> used;
    const Triangulation t = triangulate(points, weights);
    for (const auto& cell : t.cells)
        used.insert(cell.vertices.begin(), cell.vertices.end());
    EXPECT_EQ(used.count(0), 0u); // 200 lies there and is heavier
    EXPECT_EQ(used.count(200), 1u);
    EXPECT_EQ(used.count(1), 1u);
    EXPECT_EQ(used.count(201), 0u); // lighter than 1
    EXPECT_EQ(used.count(202), 1u);
    EXPECT_EQ(used.count(203), 0u); // deep in the ball of 202
    expect_neighbours_agree(t);
}

TEST(RegularTriangulation, HasNoCellsWhereNoVolumeIsSpanned)
{
    Points line, plane;
    for (int i = 0; i < 30; ++i)
    {
        line.emplace_back(0.1 * i, 0.2 * i, 0.3 * i);
        plane.emplace_back(0.1 * (i % 6), 0.3 * (i / 6), 0.5);
    }
    EXPECT_TRUE(triangulate({}).cells.empty());
    EXPECT_TRUE(triangulate({Point(1, 2, 3)}).cells.empty());
    EXPECT_TRUE(triangulate(Points(10, Point(1, 2, 3))).cells.empty());
    EXPECT_TRUE(triangulate(line).cells.empty());
    EXPECT_TRUE(triangulate(plane).cells.empty());
    plane.emplace_back(0.2, 0.2, 0.5 + 1e-15);
    const Triangulation t = triangulate(plane);
    expect_neighbours_agree(t);
    EXPECT_GT(t.finite_cells, 30);
}

TEST(RegularTriangulation, TakesNoLongerWhereAPointSeesAllOthers)
{
    // The centre of a sphere: its edges are more than 20 bits tell apart, and must not queue for the same buckets.
    const auto measure = [](const Points& points)
    {
        const std::clock_t begin = std::clock();
        EXPECT_GT(triangulate(points).finite_cells, int(points.size()));
        return double(std::clock() - begin);
    };
    std::mt19937 random(1);
    Points scattered, sphere;
    for (int i = 0; i < 300'000; ++i)
    {
        Point p;
        for (double& coordinate : p)
            coordinate = random() / 2147483648.0 - 1;
        scattered.push_back(p);
        sphere.push_back(p.normalized());
    }
    sphere.push_back(Point::Zero());
    EXPECT_LT(measure(sphere), 8 * measure(scattered));
}

TEST(RegularTriangulation, HoldsManyCellsPerSite)
{
    // Two skew lines: every edge of one makes a cell with every edge of the other.
    Points points;
    for (int i = 0; i < 60; ++i)
    {
        points.emplace_back(i / 60.0, 0, 0);
        points.emplace_back(0.3, i / 60.0 - 0.5, 1);
    }
    const Triangulation t = triangulate(points);
    expect_neighbours_agree(t);
    EXPECT_EQ(t.finite_cells, 59 * 59);
}

TEST(RegularTriangulation, StopsWhenAskedWithSeveralThreads)
{
    int calls = 0;
    const Progress progress([&](double, const std::string&) { return ++calls < 4; });
    const Points points = shapes::sphere(30'000, 1, 1).points;
    std::vector<int> all(points.size());
    std::iota(all.begin(), all.end(), 0);
    EXPECT_THROW(RegularTriangulation(points, {}, all, 2, progress), Cancelled);
    EXPECT_EQ(calls, 4);
}

TEST(RemoveSites, LeavesWhatTheOthersAloneWouldMake)
{
    for (const bool degenerate : {false, true})
    {
        const Points points = degenerate ? grid(6) : shapes::with_noise(shapes::sphere(300, 1, 1).points, 0.5, 2);
        const std::vector<double> weights(points.size(), 0);
        Triangulation t = triangulate(points, weights);
        std::set<int> hull;
        for (std::size_t c = std::size_t(t.finite_cells); c < t.cells.size(); ++c)
            hull.insert(t.cells[c].vertices.begin(), t.cells[c].vertices.end());
        std::vector<int> removed, left;
        for (int v = 0; v < int(points.size()); ++v)
            (hull.count(v) == 0 && v % 3 == 0 ? removed : left).push_back(v);
        ASSERT_GT(removed.size(), 15u);
        ASSERT_TRUE(remove_sites(t, points, weights, removed));
        expect_neighbours_agree(t);
        const Triangulation anew = RegularTriangulation(points, weights, left, 1, {}).flatten(points, weights, 1);
        EXPECT_EQ(list_cells(t), list_cells(anew));
        EXPECT_EQ(t.cells.size(), anew.cells.size());
        EXPECT_EQ(t.finite_cells, anew.finite_cells);
        EXPECT_EQ(t.centres.size(), std::size_t(t.finite_cells));
        EXPECT_FALSE(remove_sites(t, points, weights, {*hull.rbegin()}));
    }
}

TEST(RemoveSites, PutsOffASiteWhoseHoleNeedsMoreCellsThanItLeaves)
{
    const Points points = shapes::with_noise(shapes::sphere(300, 1, 1).points, 0.5, 2);
    const std::vector<double> weights(points.size(), 0);
    const Triangulation whole = triangulate(points, weights);
    std::vector<char> is_on_hull(points.size(), 0);
    for (std::size_t c = std::size_t(whole.finite_cells); c < whole.cells.size(); ++c)
        for (const int v : whole.cells[c].vertices)
            if (v != Triangulation::infinite)
                is_on_hull[v] = 1;
    std::vector<int> greedy, modest; // alone, they would need more cells, or not
    for (int v = 0; v < int(points.size()); ++v)
    {
        Triangulation t = whole;
        if (!is_on_hull[v] && v % 3 == 0)
            (remove_sites(t, points, weights, {v}) ? modest : greedy).push_back(v);
    }
    ASSERT_FALSE(greedy.empty());
    std::vector<int> removed = greedy;
    removed.insert(removed.end(), modest.begin(), modest.end());
    Triangulation t = whole;
    EXPECT_TRUE(remove_sites(t, points, weights, removed));
    expect_neighbours_agree(t);
}

TEST(PowerPredicates, AreExactNearZero)
{
    // Heights of one unit in the last place decide.
    const Site a{0.1, 0.1, 0.7, 0}, b{0.9, 0.1, 0.7, 0}, c{0.1, 0.9, 0.7, 0};
    EXPECT_EQ(find_orientation(a, b, c, {0.3, 0.3, 0.7, 0}), 0);
    EXPECT_EQ(find_orientation(a, b, c, {0.3, 0.3, std::nextafter(0.7, 1.0), 0}), 1);
    EXPECT_EQ(find_orientation(a, b, c, {0.3, 0.3, std::nextafter(0.7, 0.0), 0}), -1);

    const Site o{0, 0, 0, 0}, x{1, 0, 0, 0}, y{0, 1, 0, 0}, z{0, 0, 1, 0};
    EXPECT_EQ(find_power_side(o, x, y, z, {1, 1, 1, 0}), 0);
    EXPECT_EQ(find_power_side(o, x, y, z, {1, 1, std::nextafter(1.0, 0.0), 0}), 1);
    EXPECT_EQ(find_power_side(o, x, y, z, {1, 1, std::nextafter(1.0, 2.0), 0}), -1);
    EXPECT_EQ(find_power_side(o, x, y, z, {1, 1, 1, 1e-300}), 1); // heavier by nearly nothing
}
