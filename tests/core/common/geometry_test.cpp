#include <recon/errors.h>
#include <recon/geometry.h>

#include "tests/checks.h"
#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <limits>

using namespace recon;

TEST(UnitFrame, GivesTheSameFrameAtAnyOffsetAndScale)
{
    const Points points = shapes::sphere(200, 1, 1).points;
    const Points expected = UnitFrame(points).to_unit(points);
    for (const double scale : {1e-30, 1e-6, 1.0, 1e30})
    {
        Points moved = points;
        for (Point& p : moved)
            p = scale * (p + Vector(5, -3, 2));
        const UnitFrame frame(moved);
        Points unit = frame.to_unit(moved);
        for (std::size_t i = 0; i < points.size(); ++i)
            EXPECT_LT((unit[i] - expected[i]).norm(), 1e-14);
        frame.from_unit_in_place(unit);
        for (std::size_t i = 0; i < points.size(); ++i)
            EXPECT_LT((unit[i] - moved[i]).norm(), 1e-14 * scale);
    }
}

TEST(UnitFrame, RefusesPointsThatAreNotFinite)
{
    EXPECT_THROW(UnitFrame(Points{}), InvalidInput);
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -8e307})
        EXPECT_THROW(UnitFrame(Points{Point(0, 0, 0), Point(0, bad, 0)}), InvalidInput);
    EXPECT_NO_THROW(UnitFrame(Points{Point(0, 0, 0), Point(0, 1e300, 0)}));
}

TEST(CheckSpansVolume, NamesTheCause)
{
    const auto message = [](const Points& points) -> std::string
    {
        try
        {
            check_spans_volume(points);
            return "";
        }
        catch (const InvalidInput& e)
        {
            return e.what();
        }
    };
    EXPECT_NE(message({Point(0, 0, 0)}).find("points (1)"), std::string::npos);
    EXPECT_NE(message(Points(7, Point(1, 2, 3))).find("equal"), std::string::npos);
    Points line, plane;
    for (int i = 0; i < 20; ++i)
    {
        line.push_back(Point(1, 2, 3) * i + Point(5e6, 0, 0));
        plane.push_back(Point(i, i * i, 2 * i - 3 * i * i));
    }
    EXPECT_NE(message(line).find("line"), std::string::npos);
    EXPECT_NE(message(plane).find("plane"), std::string::npos);
    for (const double far : {1e9, 1e30})
    {
        Points strayed = shapes::sphere(100, 1, 1).points;
        strayed[40] = Point(0, far, 0);
        EXPECT_NE(message(strayed).find(far > 1e9 ? "(0, 1e+30, 0)" : "so far"), std::string::npos) << message(strayed);
    }
    EXPECT_EQ(message(shapes::sphere(10, 1e-30, 1).points), "");
    EXPECT_EQ(message(shapes::box(100, Vector(1, 1, 1e-4), 1).points), "");
}

TEST(Checks, SeeWhatIsWrongWithAMesh)
{
    TriangleMesh tetrahedron{{Point(0, 0, 0), Point(1, 0, 0), Point(0, 1, 0), Point(0, 0, 1)},
                             {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}},
                             {}};
    const checks::MeshReport good = checks::examine_mesh(tetrahedron);
    EXPECT_TRUE(good.is_closed_oriented_manifold());
    EXPECT_EQ(good.genus(), 0);
    EXPECT_NEAR(good.volume, 1.0 / 6, 1e-15);

    TriangleMesh open = tetrahedron;
    open.triangles.pop_back();
    EXPECT_FALSE(checks::examine_mesh(open).closed);
    TriangleMesh turned = tetrahedron;
    std::swap(turned.triangles[0][0], turned.triangles[0][1]);
    EXPECT_FALSE(checks::examine_mesh(turned).consistently_oriented);
    // Two tetrahedra that share one vertex.
    TriangleMesh pinched = tetrahedron;
    for (int i = 1; i < 4; ++i)
        pinched.vertices.push_back(-tetrahedron.vertices[i]);
    for (const auto& t : tetrahedron.triangles)
    {
        const auto map = [](int v) { return v == 0 ? 0 : v + 3; };
        pinched.triangles.push_back({map(t[0]), map(t[2]), map(t[1])});
    }
    EXPECT_TRUE(checks::examine_mesh(pinched).closed);
    EXPECT_FALSE(checks::examine_mesh(pinched).vertex_manifold);
}
