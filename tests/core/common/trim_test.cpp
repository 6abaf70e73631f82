#include <recon/crust/crust.h>
#include <recon/errors.h>
#include <recon/labelling/labelled_balls.h>
#include <recon/mesh/crust_mesh.h>
#include <recon/mesh/trim.h>

#include "tests/checks.h"
#include "tests/shapes.h"

#include <Eigen/Geometry>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace recon;

namespace
{

constexpr int count = 6000;
const double spacing = std::sqrt(M_PI / count); // of the sphere of radius 0.5

/// Samples of a sphere but for caps around the z axis.
Points sphere_without(double below, double above)
{
    Points result;
    for (const Point& p : shapes::sphere(count, 0.5, 3).points)
        if (p.z() > below && p.z() < above)
            result.push_back(p);
    return result;
}

TriangleMesh crust_of(const Points& samples)
{
    PhaseTimes times;
    return make_crust(label_polar_balls(samples, {}, {}, times), {});
}

void expect_manifold(const TriangleMesh& mesh)
{
    const checks::MeshReport report = checks::examine_mesh(mesh);
    EXPECT_TRUE(report.edge_manifold && report.vertex_manifold && report.consistently_oriented) << report.text();
    EXPECT_EQ(report.unreferenced_vertices, 0);
}

/// A bumpy square in x and y, higher in the middle or lower, one layer of triangles.
TriangleMesh make_terrain(double height, bool faces_up)
{
    constexpr int n = 40;
    TriangleMesh mesh;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j)
            mesh.vertices.emplace_back(double(i) / n, double(j) / n,
                                       height * std::sin(M_PI * i / n) * std::sin(M_PI * j / n));
    const auto add = [&](int a, int b, int c)
    {
        mesh.triangles.push_back(faces_up ? std::array<int, 3>{a, b, c} : std::array<int, 3>{a, c, b});
        mesh.faux_edges.push_back(faces_up ? 4 : 1); // the diagonal from c to a
    };
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
        {
            const int a = i * (n + 1) + j, b = a + n + 1;
            add(a, b, b + 1);
            add(b + 1, a + 1, a);
        }
    return mesh;
}

double area(const TriangleMesh& mesh)
{
    double sum = 0;
    for (const auto& t : mesh.triangles)
        sum += (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]).norm() / 2;
    return sum;
}

/// Whether a triangle lies over or below the place.
bool covers(const TriangleMesh& mesh, const Point& place)
{
    return std::any_of(
        mesh.triangles.begin(), mesh.triangles.end(),
        [&](const auto& t)
        {
            const auto is_left = [&](int from, int to)
            { return (mesh.vertices[to] - mesh.vertices[from]).cross(place - mesh.vertices[from]).z() >= 0; };
            return is_left(t[0], t[1]) && is_left(t[1], t[2]) && is_left(t[2], t[0]);
        });
}

double mean_rise(const TriangleMesh& mesh)
{
    Vector sum = Vector::Zero();
    for (const auto& t : mesh.triangles)
        sum += (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]) / 2;
    return sum.z();
}

} // namespace

TEST(OpenHoles, OpensWhatClosesACapAndNothingElse)
{
    const Points samples = sphere_without(-0.45, 0.35);
    TriangleMesh mesh = crust_of(samples);
    const TriangleMesh closed = mesh;
    const std::vector<int> former = open_holes(mesh, samples, 0);
    TriangleMesh by_threads = closed;
    open_holes(by_threads, samples, 0, 3);
    EXPECT_EQ(by_threads.triangles, mesh.triangles);
    expect_manifold(mesh);
    const Topology topology = measure_topology(mesh);
    EXPECT_EQ(topology.boundary_loops, 2);
    EXPECT_EQ(topology.components, 1);
    EXPECT_EQ(topology.genus(), 0);
    ASSERT_EQ(former.size(), mesh.vertices.size());
    for (std::size_t v = 0; v < former.size(); ++v)
        EXPECT_EQ(mesh.vertices[v], closed.vertices[former[v]]);
    for (const Point& v : mesh.vertices)
    {
        EXPECT_LT(v.z(), 0.35 + 2 * spacing);
        EXPECT_GT(v.z(), -0.45 - 2 * spacing);
    }
    EXPECT_NEAR(area(mesh), M_PI * 0.8, 0.08); // a rim is up to two spacings wide
}

TEST(OpenHoles, LeavesAClosedCloudAsItIs)
{
    // Random samples leave gaps; where one half has a quarter of the samples these are as large as holes of the other.
    Points samples;
    int i = 0;
    for (const Point& p : shapes::sphere(4 * count, 0.5, 7).points)
        if (p.x() > 0 || ++i % 4 == 0)
            samples.push_back(p);
    TriangleMesh mesh = crust_of(samples);
    const TriangleMesh closed = mesh;
    open_holes(mesh, samples, 0);
    EXPECT_EQ(mesh.triangles, closed.triangles);
}

TEST(OpenHoles, SmallGapsStayClosed)
{
    for (const double radius : {2.0, 6.0})
    {
        Points samples;
        for (const Point& p : shapes::sphere(count, 0.5, 9).points)
            if ((p - Point(0.5, 0, 0)).norm() > radius * spacing)
                samples.push_back(p);
        TriangleMesh mesh = crust_of(samples);
        open_holes(mesh, samples, 0);
        EXPECT_EQ(measure_topology(mesh).boundary_loops, radius > 4) << radius;
    }
}

TEST(OpenHoles, WhatBacksCarryIsBare)
{
    // The second half of the samples was put there behind the first.
    Points samples = sphere_without(-1, 0), backs = sphere_without(0, 1);
    samples.insert(samples.end(), backs.begin(), backs.end());
    TriangleMesh mesh = crust_of(samples);
    open_holes(mesh, samples, int(backs.size()));
    EXPECT_EQ(measure_topology(mesh).boundary_loops, 1);
    for (const Point& v : mesh.vertices)
        EXPECT_LT(v.z(), 2 * spacing);
}

// A scanner stands over a floor that it reads in rings, at last ten times as far apart as the readings of a ring.
TEST(OpenHoles, RingsOfAScannerAreNoHoles)
{
    const Point place(0, 0, 1);
    Points samples;
    for (double down = 60; down > 12; down -= 2)
        for (double about = 0; about < 360; about += 0.25)
        {
            const double r = 1 / std::tan(down * M_PI / 180);
            const bool is_in_shadow = r > 1.5 && (about < 40 || about > 320);
            if (!is_in_shadow)
                samples.emplace_back(r * std::cos(about * M_PI / 180), r * std::sin(about * M_PI / 180), 0);
        }
    TriangleMesh floor = make_terrain(0, true);
    for (Point& p : floor.vertices)
        p = 5.6 * (p - Vector(0.5, 0.5, 0));
    TriangleMesh without_place = floor;
    open_holes(floor, samples, 0, 1, {}, Viewpoints(place));
    const auto is_covered = [&](double x, double y) { return covers(floor, {x, y, 0}); };
    for (const double r : {1.0, 1.5, 2.0, 2.5})
        for (const double about : {1.0, 2.0, 3.0, 4.0, 5.0})
            EXPECT_TRUE(is_covered(r * std::cos(about), r * std::sin(about))) << r << " " << about;
    EXPECT_FALSE(is_covered(0, 0)) << "below the scanner";
    EXPECT_FALSE(is_covered(2.3, 0)) << "in the shadow";
    open_holes(without_place, samples, 0);
    EXPECT_LT(area(without_place), 0.6 * area(floor));
}

TEST(TrimByLength, LeavesManifoldRims)
{
    // So short that rims meet in single vertices.
    const Points samples = sphere_without(-1, 1);
    for (const double length : {0.4, 0.5, 0.6, 0.8})
    {
        TriangleMesh mesh = crust_of(samples);
        const std::size_t before = mesh.triangles.size();
        trim_by_length(mesh, samples, length * spacing);
        expect_manifold(mesh);
        EXPECT_LT(mesh.triangles.size(), before) << length;
    }
}

TEST(OpenHoles, CanBeCancelled)
{
    const Points samples = sphere_without(-1, 0.3);
    TriangleMesh mesh = crust_of(samples);
    const Progress progress([](double, const std::string&) { return false; });
    EXPECT_THROW(open_holes(mesh, samples, 0, 1, progress), Cancelled);
}

TEST(TrimByLength, AllMayGo)
{
    TriangleMesh mesh = crust_of(sphere_without(-1, 1));
    trim_by_length(mesh, {Point(9, 9, 9)}, 1);
    EXPECT_TRUE(mesh.triangles.empty());
    EXPECT_TRUE(mesh.vertices.empty());
}

TEST(TrimByLength, ATerrainFacesUp)
{
    for (const double height : {-0.2, 0.2})
        for (const bool faces_up : {false, true})
        {
            TriangleMesh mesh = make_terrain(height, faces_up);
            trim_by_length(mesh, mesh.vertices, 1);
            EXPECT_NEAR(mean_rise(mesh), 1, 1e-9) << height;
            for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
            {
                // The faux edge is still the longest.
                const auto& t = mesh.triangles[i];
                int longest = 0;
                const auto length = [&](int k) { return (mesh.vertices[t[(k + 1) % 3]] - mesh.vertices[t[k]]).norm(); };
                for (int k = 1; k < 3; ++k)
                    if (length(k) > length(longest))
                        longest = k;
                EXPECT_EQ(mesh.faux_edges[i], 1 << longest) << i;
            }
        }
    // Too high to be one: nothing tells which side is right.
    TriangleMesh dome = make_terrain(0.5, false);
    trim_by_length(dome, dome.vertices, 1);
    EXPECT_NEAR(mean_rise(dome), -1, 1e-9);
}

TEST(TrimByLength, PartsFaceTheViewpoint)
{
    for (const double z : {-50, 50})
        for (const bool up : {false, true})
        {
            TriangleMesh terrain = make_terrain(0.1, up);
            trim_by_length(terrain, terrain.vertices, 1, 1, {}, Viewpoints(Point(0, 0, z)));
            EXPECT_EQ(mean_rise(terrain) > 0, z > 0) << z << " " << up;
        }
    // Each the one that saw it.
    const Vector aside(1'000, 0, 0);
    const Viewpoints viewpoints({{0, 0, 50}, {1'000, 0, -50}}, {{0, 0, 0}, aside}, {0, 1});
    for (const bool is_aside : {false, true})
    {
        TriangleMesh terrain = make_terrain(0.1, true);
        for (Point& p : terrain.vertices)
            p += is_aside * aside;
        trim_by_length(terrain, terrain.vertices, 1, 1, {}, viewpoints);
        EXPECT_EQ(mean_rise(terrain) < 0, is_aside);
    }
}
