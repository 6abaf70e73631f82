#include <recon/crust/crust.h>
#include <recon/labelling/labelled_balls.h>
#include <recon/mesh/taut_closing.h>
#include <recon/mesh/triangle_cuts.h>

#include "tests/checks.h"
#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

using namespace recon;

namespace
{

Points sphere()
{
    return shapes::sphere(3000, 0.5, 1).points;
}

TriangleMesh sphere_crust()
{
    PhaseTimes times;
    return make_crust(label_polar_balls(sphere(), {}, {}, times), {});
}

Points pick(const Points& points, const std::function<bool(const Point&)>& is_wanted)
{
    Points result;
    std::copy_if(points.begin(), points.end(), std::back_inserter(result), is_wanted);
    return result;
}

bool is_low(const Point& p)
{
    return p.z() < 0;
}

/// Appends a body to a mesh.
void add(TriangleMesh& mesh, const TriangleMesh& body, double scale, const Vector& shift)
{
    const int first = int(mesh.vertices.size());
    for (const Point& p : body.vertices)
        mesh.vertices.push_back(scale * p + shift);
    for (const auto& t : body.triangles)
        mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

int count_cuts(const TriangleMesh& mesh)
{
    const TriangleCuts cuts(mesh, std::vector<char>(mesh.vertices.size(), 1), 1);
    int result = 0;
    for (const int n : cuts.count(mesh.vertices))
        result += n;
    return result;
}

TEST(DrawBareFacesTaut, LaysAFlatLidOverWhatHasNoSamples)
{
    const TriangleMesh before = sphere_crust();
    TriangleMesh mesh = before;
    const Points samples = pick(sphere(), is_low);
    const int moved = draw_bare_faces_taut(mesh, samples);
    EXPECT_GT(moved, int(before.vertices.size()) / 3);
    EXPECT_LT(moved, int(before.vertices.size()) / 2);
    EXPECT_EQ(mesh.triangles, before.triangles);
    EXPECT_EQ(count_cuts(mesh), 0);
    // Within two spacings of the samples the sphere stays, some 0.05 high.
    EXPECT_NEAR(checks::examine_mesh(mesh).volume / checks::examine_mesh(before).volume, 0.5, 0.08);
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    {
        EXPECT_LT(mesh.vertices[v].z(), 0.12);
        EXPECT_TRUE(!is_low(before.vertices[v]) || mesh.vertices[v] == before.vertices[v]);
    }
}

TEST(DrawBareFacesTaut, MovesNothingWhereSamplesAreNorWhatHangsOnNothing)
{
    const TriangleMesh before = sphere_crust();
    TriangleMesh mesh = before;
    EXPECT_EQ(draw_bare_faces_taut(mesh, before.vertices), 0);
    EXPECT_EQ(draw_bare_faces_taut(mesh, {}), 0);
    add(mesh, before, 0.2, Vector(3, 0, 0));
    const Points both = mesh.vertices;
    EXPECT_EQ(draw_bare_faces_taut(mesh, before.vertices), 0);
    EXPECT_EQ(mesh.vertices, both);
}

TEST(DrawBareFacesTaut, IsHeldWhereItWouldCutWhatRisesThroughIt)
{
    const TriangleMesh globe = sphere_crust();
    TriangleMesh mesh = globe;
    add(mesh, globe, 0.3, Vector(0, 0, 0.1)); // from -0.05 to 0.25, where the lid would lie at 0.1
    const Points hill(mesh.vertices.begin() + std::ptrdiff_t(globe.vertices.size()), mesh.vertices.end());
    Points samples = pick(sphere(), is_low);
    samples.insert(samples.end(), hill.begin(), hill.end());
    EXPECT_GT(draw_bare_faces_taut(mesh, samples), 0);
    EXPECT_EQ(count_cuts(mesh), 0);
    EXPECT_TRUE(std::equal(hill.begin(), hill.end(), mesh.vertices.end() - std::ptrdiff_t(hill.size())));
    double highest = 0, lid = 0;
    for (std::size_t v = 0; v < globe.vertices.size(); ++v)
    {
        highest = std::max(highest, mesh.vertices[v].z());
        if (globe.vertices[v].z() > 0.1)
            lid += mesh.vertices[v].z() < 0.7 * globe.vertices[v].z();
    }
    EXPECT_GT(highest, 0.25); // over the hill
    EXPECT_GT(lid, 100);      // beside it
}

TEST(DrawBareFacesTaut, StandsTrianglesWithoutAreaAndIsTheSameForAnyNumberOfThreads)
{
    TriangleMesh mesh = sphere_crust();
    const Points samples = pick(sphere(), is_low);
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
        if (mesh.vertices[v].z() > 0.3) // a pin's head of many corners in one place
            mesh.vertices[v] = Point(0, 0, 0.6);
    TriangleMesh other = mesh;
    EXPECT_GT(draw_bare_faces_taut(mesh, samples, 1), 0);
    draw_bare_faces_taut(other, samples, 3);
    EXPECT_EQ(mesh.vertices, other.vertices);
    EXPECT_TRUE(checks::examine_mesh(mesh).finite);
}

TEST(TriangleCuts, CountsWhatCrossesButNotNeighbours)
{
    TriangleMesh mesh;
    mesh.vertices = {Point(0, 0, 0),   Point(1, 0, 0),     Point(0, 1, 0),      Point(1, 1, 0),
                     Point(-9, 9, 9),  Point(0.2, 0.2, 1), Point(0.2, 0.2, -1), Point(2, 2, 0.1),
                     Point(2, -2, -1), Point(2, -2, 1),    Point(4, -2, 0)};
    mesh.triangles = {{0, 1, 2}, {1, 3, 2}, {5, 6, 7}, {0, 4, 5}, {8, 9, 10}};
    const TriangleCuts cuts(mesh, {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 1);
    EXPECT_EQ(cuts.moving(), (std::vector<int>{0, 3}));
    EXPECT_EQ(cuts.count(mesh.vertices), (std::vector<int>{1, 0}));
    Points places = mesh.vertices;
    places[0] = Point(0.5, 0.5, 0); // without area
    EXPECT_EQ(cuts.count(places).front(), 0);
    places[0] = Point(4, -4, 0); // beyond where the moving ones were, through the last
    EXPECT_EQ(cuts.count(places).front(), 2);
    EXPECT_EQ(cuts.list(places), (std::vector<std::pair<int, int>>{{0, 2}, {0, 4}, {3, 4}}));
}

} // namespace
