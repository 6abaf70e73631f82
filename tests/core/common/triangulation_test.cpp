#include <recon/errors.h>
#include <recon/triangulation/delaunay.h>
#include <recon/triangulation/power_centre.h>
#include <recon/triangulation/power_diagram.h>

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

using namespace recon;

namespace
{

double power(const Point& x, const Ball& ball)
{
    return (x - ball.centre).squaredNorm() - ball.radius * ball.radius;
}

std::vector<Ball> random_balls(int n)
{
    const Points centres = shapes::with_noise(shapes::sphere(n, 1, 3).points, 0.3, 4);
    std::vector<Ball> balls;
    for (int i = 0; i < n; ++i)
        balls.push_back({centres[i], 0.05 + 0.2 * (i % 7) / 7.0});
    return balls;
}

void expect_sound(const Triangulation& t)
{
    for (int c = 0; c < int(t.cells.size()); ++c)
        for (int i = 0; i < 4; ++i)
        {
            const auto& neighbour = t.cells[t.cells[c].neighbours[i]];
            EXPECT_EQ(std::count(neighbour.neighbours.begin(), neighbour.neighbours.end(), c), 1);
            for (int k = 0; k < 4; ++k)
                EXPECT_EQ(neighbour.position_of(t.cells[c].vertices[k]) < 4, k != i);
        }
}

} // namespace

TEST(TriangulateDelaunay, HasEmptyCircumspheres)
{
    Points points = shapes::with_noise(shapes::sphere(300, 1, 1).points, 0.05, 2);
    points.push_back(points[17]); // a duplicate does not appear
    const Triangulation t = triangulate_delaunay(points);
    expect_sound(t);
    std::set<int> used;
    for (int c = 0; c < t.finite_cells; ++c)
    {
        const auto& cell = t.cells[c];
        used.insert(cell.vertices.begin(), cell.vertices.end());
        const double radius = (points[cell.vertices[0]] - t.centres[c]).norm();
        for (const int v : cell.vertices)
            EXPECT_NEAR((points[v] - t.centres[c]).norm(), radius, 1e-6 * radius);
        for (const Point& p : points)
            EXPECT_GT((p - t.centres[c]).norm(), radius * (1 - 1e-6));
    }
    EXPECT_EQ(used.size(), 300u);
}

TEST(TriangulateDelaunay, StopsWhenAsked)
{
    const Progress progress([](double, const std::string&) { return false; });
    EXPECT_THROW(triangulate_delaunay(shapes::sphere(50, 1, 1).points, progress), Cancelled);
}

TEST(PowerDiagram, CentresHaveTheLeastPowerToTheirOwnBalls)
{
    const std::vector<Ball> balls = random_balls(200);
    PowerDiagram diagram(balls);
    std::set<int> present;
    for (int b = 0; b < int(balls.size()); ++b)
        present.insert(b);
    Triangulation t = diagram.triangulation();
    std::set<int> hull, inside;
    for (int c = 0; c < int(t.cells.size()); ++c)
        for (const int v : t.cells[c].vertices)
            (c < t.finite_cells ? inside : hull).insert(v);
    for (const int v : hull)
        inside.erase(v);
    ASSERT_GT(inside.size(), 12u);
    const std::vector<int> deep(inside.begin(), inside.end());
    // None; few, in a triangulation that is mended, also for a second time; on the hull; more, after which it is made
    // anew.
    for (const std::vector<int>& removed :
         {std::vector<int>{}, std::vector<int>(deep.begin(), deep.begin() + 4),
          std::vector<int>(deep.begin() + 4, deep.begin() + 6), std::vector<int>{*hull.rbegin()},
          std::vector<int>(deep.begin() + 6, deep.begin() + 13)})
    {
        diagram.remove(removed, t);
        for (const int b : removed)
            present.erase(b);
        expect_sound(t);
        for (int c = 0; c < t.finite_cells; ++c)
        {
            const Point& centre = t.centres[c];
            const double size = 1 + centre.norm();
            const double own = power(centre, balls[t.cells[c].vertices[0]]);
            for (const int b : present)
            {
                const double difference = power(centre, balls[b]) - own;
                EXPECT_LT(t.cells[c].position_of(b) < 4 ? std::abs(difference) : -difference, 1e-6 * size * size);
            }
            for (const int v : t.cells[c].vertices)
                EXPECT_TRUE(present.count(v));
        }
        const std::size_t mended = t.cells.size();
        t = diagram.triangulation();
        EXPECT_EQ(mended, t.cells.size());
    }
}

TEST(FindPowerCentre, IsRightOnCellsTooFlatForDouble)
{
    // Four points near a circle of the unit sphere, out of one plane by the rounding of their coordinates.
    for (const double height : {1e-3, 1e-8, 1e-12, 3e-16})
    {
        std::array<Point, 4> points;
        for (int i = 0; i < 4; ++i)
            points[i] = {0.6 * std::cos(1.1 * i), 0.6 * std::sin(1.1 * i), 0.8 + (i % 2 ? height : 0)};
        const Point centre = find_power_centre(points, {0, 0, 0, 0});
        double shortest = 1e300, longest = 0;
        for (const Point& p : points)
        {
            shortest = std::min(shortest, (p - centre).norm());
            longest = std::max(longest, (p - centre).norm());
        }
        EXPECT_LT(longest - shortest, 1e-8 * longest) << height;
    }
    // On one circle, and one of them out of its plane by the last bits: its whole axis is as far from all four but for
    // rounding, only the middle of these planes exactly.
    constexpr double x = 0.2196091, y = 0.3343229;
    for (const double height : {0.0429161397669052, 0.3371, -0.0418097})
        for (const int bits : {1, 2, 3})
        {
            double above = height;
            for (int k = 0; k < bits; ++k)
                above = std::nextafter(above, 1.0);
            const Point ring_centre = find_power_centre(
                {Point(-x, -y, height), Point(y, -x, above), Point(x, y, height), Point(-x, y, height)}, {0, 0, 0, 0});
            EXPECT_LT((ring_centre - Point(0, 0, height)).norm(), 1e-9) << height << " " << bits;
        }
    // Weights move the centre along the axis by a known amount: |x|^2 - 1 = |x - p|^2.
    const Point moved =
        find_power_centre({Point(0, 0, 0), Point(1, 0, 0), Point(0, 1, 0), Point(0, 0, 1)}, {0.5, 0, 0, 0});
    EXPECT_LT((moved - Point::Constant(0.75)).norm(), 1e-14);
}

TEST(Triangulation, RingsGoRoundTheirEdgeFromTheLowestCell)
{
    const Triangulation t = triangulate_delaunay(shapes::with_noise(shapes::sphere(100, 1, 1).points, 0.3, 2));
    std::vector<int> ring;
    const CellsAtVertices at = list_cells_at_vertices(t, 100);
    int rings = 0;
    for (int c = 0; c < t.finite_cells; ++c)
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j)
            {
                if (i == j)
                    continue;
                const int a = t.cells[c].vertices[i], b = t.cells[c].vertices[j];
                std::set<int> expected;
                for (int k = at.first[a]; k < at.first[a + 1]; ++k)
                    if (t.cells[at.cell[k]].position_of(b) < 4)
                        expected.insert(at.cell[k]);
                const bool is_lowest = *expected.begin() == c && t.is_finite(*expected.rbegin());
                ASSERT_EQ(t.list_ring_from_lowest(c, a, b, ring), is_lowest);
                EXPECT_LE(is_lowest, t.can_be_lowest(c, i, j));
                EXPECT_EQ(is_lowest ? std::set<int>(ring.begin(), ring.end()) : expected, expected);
                EXPECT_EQ(is_lowest ? ring.size() : expected.size(), expected.size());
                rings += is_lowest;
            }
    EXPECT_GT(rings, 200);
}
