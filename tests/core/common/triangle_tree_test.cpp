#include <recon/mesh/triangle_tree.h>

#include <gtest/gtest.h>

#include <tests/shapes.h>

#include <algorithm>
#include <limits>

using namespace recon;

namespace
{

/// Small triangles anywhere in a cube of side 1, so that no two neighbours in the list lie side by side.
TriangleMesh confetti(int count)
{
    TriangleMesh result;
    shapes::Random random(3);
    const auto somewhere = [&](double size)
    { return Point(size * shapes::draw_vector([&] { return shapes::uniform(random); })); };
    for (int i = 0; i < count; ++i)
    {
        const Point place = somewhere(1);
        for (int k = 0; k < 3; ++k)
            result.vertices.push_back(place + somewhere(0.1));
        result.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return result;
}

TEST(SquaredDistance, IsToTheInsideASideOrACorner)
{
    const Point a(0, 0, 0), b(2, 0, 0), c(0, 2, 0);
    EXPECT_DOUBLE_EQ(squared_distance(Point(0.5, 0.5, 3), a, b, c), 9);
    EXPECT_DOUBLE_EQ(squared_distance(Point(0.5, 0.5, -3), a, c, b), 9);
    EXPECT_DOUBLE_EQ(squared_distance(Point(1, -2, 1), a, b, c), 5);
    EXPECT_DOUBLE_EQ(squared_distance(Point(2, 2, 0), a, b, c), 2);
    EXPECT_DOUBLE_EQ(squared_distance(Point(-1, -2, 2), a, b, c), 9);
    EXPECT_DOUBLE_EQ(squared_distance(Point(5, 4, 0), a, b, b), 25); // a segment
    EXPECT_DOUBLE_EQ(squared_distance(Point(1, 2, 2), a, a, a), 9);
}

TEST(TriangleTree, FindsTheNearestTriangleAndThoseNearABox)
{
    const TriangleMesh mesh = confetti(1001); // the last run is not full
    const TriangleTree tree(mesh.vertices, mesh.triangles);
    shapes::Random random(4);
    for (int i = 0; i < 200; ++i)
    {
        const Point p = 1.4 * shapes::draw_vector([&] { return shapes::uniform(random); });
        const Box box{p - Point::Constant(0.05), p + Point::Constant(0.05)};
        double least = std::numeric_limits<double>::infinity();
        std::vector<int> near, found;
        for (int t = 0; t < int(mesh.triangles.size()); ++t)
        {
            const Point &a = mesh.vertices[3 * t], &b = mesh.vertices[3 * t + 1], &c = mesh.vertices[3 * t + 2];
            least = std::min(least, squared_distance(p, a, b, c));
            const Box other = bounding_box({a, b, c});
            if ((other.minimum.array() <= box.maximum.array()).all() &&
                (other.maximum.array() >= box.minimum.array()).all())
                near.push_back(t);
        }
        tree.visit_near(box, [&](int t) { found.push_back(t); });
        std::sort(found.begin(), found.end());
        EXPECT_EQ(tree.squared_distance_from(p), least);
        const auto [triangle, place] = tree.nearest(p);
        const auto& [a, b, c] = mesh.triangles[std::size_t(triangle)];
        EXPECT_EQ((place - p).squaredNorm(), least);
        EXPECT_LT(squared_distance(place, mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]), 1e-24);
        EXPECT_EQ(found, near);
    }
}

TEST(TriangleTree, StandsAnEmptyListAndOneTriangle)
{
    const TriangleMesh one = confetti(1), none;
    const TriangleTree nothing(none.vertices, none.triangles), single(one.vertices, one.triangles);
    int visits = 0;
    nothing.visit_near(bounding_box(one.vertices), [&](int) { ++visits; });
    EXPECT_EQ(visits, 0);
    EXPECT_EQ(nothing.squared_distance_from(Point::Zero()), std::numeric_limits<double>::infinity());
    single.visit_near(bounding_box(one.vertices), [&](int) { ++visits; });
    EXPECT_EQ(visits, 1);
    EXPECT_EQ(single.squared_distance_from(one.vertices[0]), 0);
}

} // namespace
