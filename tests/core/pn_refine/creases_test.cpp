#include "crease_shapes.h"
#include "one_thread.h"

#include "filter_pn_refine/refine.h"

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <utility>

namespace
{

using namespace recon;

/// Cube of side 2 with m x m samples a face; those on edges and corners stand twice and three times.
OrientedSamples cube(int m)
{
    OrientedSamples samples;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> u(-0.25 / m, 0.25 / m);
    for (int face = 0; face < 6; ++face)
    {
        Vector normal = Vector::Zero();
        normal[face / 2] = face % 2 ? 1 : -1;
        for (int i = 0; i < m; ++i)
            for (int j = 0; j < m; ++j)
            {
                const bool inside = i > 0 && j > 0 && i < m - 1 && j < m - 1;
                const double a = -1 + 2.0 * i / (m - 1), b = -1 + 2.0 * j / (m - 1);
                Point p;
                p[face / 2] = normal[face / 2];
                p[(face / 2 + 1) % 3] = inside ? a + u(random) : a;
                p[(face / 2 + 2) % 3] = inside ? b + u(random) : b;
                append(samples, p, normal);
            }
    }
    return samples;
}

TEST(Creases, CubeStaysSharp)
{
    const int m = 8;
    const OrientedSamples samples = cube(m);
    const PnRefinement refined = refine_points(samples, one_thread(5));
    EXPECT_EQ(refined.crease_segments, 12 * (m - 1));
    EXPECT_EQ(refined.boundary_segments, 0);
    EXPECT_EQ(refined.left_out, 0);
    EXPECT_GT(refined.points.size(), 10000u);
    for (std::size_t i = 0; i < refined.points.size(); ++i)
    {
        EXPECT_LT(shapes::distance_to_box(refined.points[i], Vector(2, 2, 2)), 1e-12);
        EXPECT_NEAR(refined.normals[i].cwiseAbs().maxCoeff(), 1, 1e-12);
        EXPECT_NEAR(refined.points[i].dot(refined.normals[i]), 1, 1e-12); // the normal of the point's own face
    }
}

TEST(Creases, NewCreasePointsCarryBothNormalsAndHalveTheEdges)
{
    const int m = 8;
    const OrientedSamples samples = cube(m);
    const PnRefinement refined = refine_points(samples, one_thread(3)); // thirds twice
    std::vector<double> on_edge;
    std::map<double, int> normals_there;
    for (std::size_t i = 0; i < refined.points.size(); ++i)
    {
        const Point& p = refined.points[i];
        if (std::abs(p.x() - 1) < 1e-9 && std::abs(p.y() - 1) < 1e-9 && std::abs(std::abs(p.z()) - 1) > 1e-9)
        {
            const double key = std::round(p.z() * 1e9);
            on_edge.push_back(key);
            normals_there[key] += refined.normals[i].x() > 0.999 ? 1 : 100;
        }
    }
    EXPECT_EQ(normals_there.size(), std::size_t(7 * 8)); // 7 segments in 9 parts, ends not counted
    for (const auto& [z, mark] : normals_there)
        EXPECT_EQ(mark, 101) << z; // one along x, one along y
}

TEST(Creases, WithoutPreservingThemTheyAreNotRefined)
{
    PnRefineOptions options = one_thread(2);
    options.preserve_creases = false;
    EXPECT_EQ(refine_points(cube(6), options).crease_segments, 0);
}

TEST(Creases, AFaceDoesNotGoOnBehindItsEdge)
{
    // A floor on which a wall stands, two spacings thick: floor samples lie on both sides of it.
    constexpr double half = 0.1, height = 0.5;
    OrientedSamples samples;
    shapes::Random random(3);
    const auto uniform = [&](double from, double to) { return from + (to - from) * shapes::uniform(random); };
    for (int i = 0; i < 400; ++i)
        for (const double side : {-1.0, 1.0})
        {
            append(samples, {side * uniform(half, 1), uniform(-1, 1), 0}, Vector::UnitZ());
            if (i % 4 == 0)
                append(samples, {side * half, uniform(-1, 1), uniform(0, height)}, Vector(side, 0, 0));
        }
    const PnRefinement refined = refine_points(samples, one_thread(3));
    EXPECT_GT(refined.crease_points, 40);
    int on_floor = 0, under_wall = 0;
    for (const Point& p : refined.points)
        if (std::abs(p.z()) < 0.01)
        {
            ++on_floor;
            under_wall += std::abs(p.x()) < 0.8 * half;
        }
    // A floor that goes on has 5 per cent there; a few triangles of samples that lie at no edge still cross.
    EXPECT_LT(under_wall, 0.03 * on_floor);
}

TEST(Creases, SmoothShapesThatAreSampledSparselyHaveNone)
{
    // Nine samples go round the tube: neighbours' normals differ by as much as at an edge.
    EXPECT_EQ(refine_points(shapes::torus(1000, 1, 0.3, 1), one_thread(0)).crease_points, 0);
    EXPECT_EQ(refine_points(shapes::torus(600, 1, 0.5, 2), one_thread(0)).crease_points, 0);
    // A pebble whose rim is as sharp as samples are apart.
    OrientedSamples pebble = shapes::sphere(2000, 1, 3);
    for (std::size_t i = 0; i < pebble.points.size(); ++i)
    {
        pebble.points[i].z() *= 0.2;
        pebble.normals[i].z() /= 0.2;
    }
    EXPECT_EQ(refine_points(pebble, one_thread(0)).crease_points, 0);
}

TEST(Creases, NormalsThatAreNotExactShowNone)
{
    OrientedSamples samples = shapes::box(4000, Vector(2, 2, 2), 5);
    shapes::Random random(1);
    for (Vector& n : samples.normals)
        n += 0.3 * shapes::draw_vector([&] { return shapes::uniform(random) - 0.5; });
    EXPECT_EQ(refine_points(samples, one_thread(0)).crease_points, 0);
}

TEST(Creases, TheMouthOfABoreStaysOpen)
{
    constexpr double bore = 0.15; // 2.5 spacings
    const OrientedSamples samples = bored_plate(0.4, bore, 280);
    int in_mouth[2], crease_points[2];
    for (const bool detects : {false, true})
    {
        PnRefineOptions options = one_thread(3);
        options.detect_creases = detects;
        const PnRefinement refined = refine_points(samples, options);
        crease_points[detects] = refined.crease_points;
        in_mouth[detects] = int(std::count_if(refined.points.begin(), refined.points.end(),
                                              [&](const Point& p) { return p.head<2>().norm() < 0.8 * bore; }));
    }
    EXPECT_EQ(crease_points[0], 0);
    EXPECT_GT(crease_points[1], 400);
    EXPECT_LE(in_mouth[1], in_mouth[0]);
    EXPECT_LE(in_mouth[1], 5);
}

TEST(Creases, LieWhereCurvedFacesEnd)
{
    constexpr double bore = 0.4;
    const PnRefinement refined = refine_points(bored_plate(0.4, bore, 400), one_thread(0));
    int on_bore = 0;
    double farthest = 0;
    for (int i = 0; i < refined.crease_points; ++i)
        if (const double r = refined.points[std::size_t(i)].head<2>().norm(); r < 0.7)
        {
            ++on_bore;
            farthest = std::max(farthest, std::abs(r - bore));
        }
    // Two circles; a position every spacing and a half, twice each.
    EXPECT_GT(on_bore, 2 * 2 * 2 * M_PI * bore / (1.5 * 0.05));
    EXPECT_LT(farthest, 0.25 * 0.05);
}

TEST(Creases, EdgesThatEndElsewhereLeaveAFaceWhole)
{
    // A floor, and creases along a short wall that stands on it: beyond their ends they say nothing.
    OrientedSamples samples;
    shapes::Random random(2);
    for (int i = 0; i < 2000; ++i)
        if (const double x = 40 * shapes::uniform(random) - 20, y = 50 * shapes::uniform(random) - 25;
            std::abs(y) > 5 || x < 0 || x > 1)
            append(samples, {x, y, 0}, Vector::UnitZ());
    for (int y = -5; y <= 5; ++y)
        for (const double z : {0.0, 0.0, 1.0, 2.0})
            append(samples, {0, double(y), z},
                   z > 0 || samples.points.back().z() == 0 ? Vector(-1, 0, 0) : Vector::UnitZ());
    PnRefineOptions options = one_thread(3);
    options.detect_creases = false;
    const PnRefinement refined = refine_points(samples, options);
    int behind = 0, elsewhere = 0;
    for (const Point& p : refined.points)
        if (std::abs(p.y()) < 5 && p.z() < 0.1)
        {
            behind += p.x() > 4 && p.x() < 14;
            elsewhere += p.x() < -4 && p.x() > -14;
        }
    EXPECT_GT(behind, 0.9 * elsewhere);
}

TEST(Creases, PlanesOfThinWallsDoNotMeetInside)
{
    // A square tube with walls of 1.2 spacings: the inner plane of one wall meets the outer one of the next inside.
    constexpr double inner = 0.93;
    int on_edges = 0, inside = 0;
    for (std::uint64_t seed = 9; seed <= 12; ++seed)
    {
        OrientedSamples samples;
        shapes::Random random(seed);
        for (int i = 0; i < 8 * 560; ++i)
        {
            const double u = 2 * shapes::uniform(random) - 1, z = 2 * shapes::uniform(random) - 1;
            const double half = i % 2 ? 1 : inner, side = i % 4 < 2 ? 1 : -1;
            Point p(half * side, half * u, z);
            Vector n(i % 2 ? side : -side, 0, 0);
            if (i % 8 < 4)
            {
                std::swap(p.x(), p.y());
                std::swap(n.x(), n.y());
            }
            append(samples, p, n);
        }
        const PnRefinement refined = refine_points(samples, one_thread(0));
        for (int i = 0; i < refined.crease_points; ++i)
        {
            const Point p = refined.points[std::size_t(i)].cwiseAbs();
            const double difference = std::abs(p.x() - p.y());
            ++(difference < 1e-9 ? on_edges : inside);
        }
    }
    EXPECT_GT(on_edges, 4 * 250);
    EXPECT_LT(inside, 0.05 * on_edges);
}

TEST(Creases, LieAsDenselyAsTheSamplesAroundThem)
{
    OrientedSamples samples;
    shapes::Random random(4);
    const OrientedSamples box = shapes::box(40000, Vector(2, 2, 2), 5);
    for (std::size_t i = 0; i < box.points.size(); ++i)
        if (box.points[i].z() > 0 || shapes::uniform(random) < 0.05)
        {
            append(samples, box.points[i], box.normals[i]);
        }
    const PnRefinement refined = refine_points(samples, one_thread(0));
    int dense = 0, sparse = 0; // on the four upright edges
    for (int i = 0; i < refined.crease_points; ++i)
        if (const Point& p = refined.points[std::size_t(i)];
            std::abs(std::abs(p.x()) - 1) < 1e-9 && std::abs(std::abs(p.y()) - 1) < 1e-9)
            ++(p.z() > 0.1 ? dense : sparse);
    EXPECT_GT(dense, 2.5 * sparse);
    EXPECT_GT(sparse, 4 * 2 * 5);
}

TEST(Creases, FollowEachOtherInSpace)
{
    // Else each search among the samples takes longer.
    const PnRefinement refined = refine_points(shapes::box(20000, Vector(2, 2, 2), 5), one_thread(0));
    ASSERT_GT(refined.crease_points, 1000);
    double way = 0;
    for (std::size_t i = 1; i < std::size_t(refined.crease_points); ++i)
        way += (refined.points[i] - refined.points[i - 1]).norm();
    EXPECT_LT(way, 4 * 12 * 2); // four times the edges
}

TEST(Creases, AreDetectedFromNormals)
{
    const OrientedSamples samples = shapes::box(4000, Vector(2, 2, 2), 5); // none on the edges
    PnRefineOptions options = one_thread(2);
    options.detect_creases = false;
    EXPECT_EQ(refine_points(samples, options).crease_points, 0);
    options.detect_creases = true;
    const PnRefinement refined = refine_points(samples, options);
    EXPECT_GT(refined.crease_points, 400);
    int positions = 0, corners = 0;
    for (int i = 0; i < refined.crease_points; ++i)
    {
        const Point& p = refined.points[std::size_t(i)];
        positions += i == 0 || p != refined.points[std::size_t(i - 1)];
        corners += (p.cwiseAbs() - Vector::Ones()).norm() < 1e-9;
    }
    EXPECT_EQ(corners, 8 * 3); // with the normals of three faces
    // Twelve lines that end before the corners would be as many fewer than their positions.
    EXPECT_GT(refined.crease_segments, positions);
    for (int i = 0; i < refined.crease_points; ++i)
    {
        // On two faces at once.
        Vector away = (Vector::Ones() - refined.points[std::size_t(i)].cwiseAbs()).cwiseAbs();
        std::sort(away.data(), away.data() + 3);
        EXPECT_LT(away[1], 1e-9);
    }
    // What is put onto the lines stands there twice, with the normals of both faces.
    int pairs = 0;
    for (std::size_t i = 1; i < refined.points.size(); ++i)
        if (refined.points[i] == refined.points[i - 1])
        {
            ++pairs;
            EXPECT_NEAR(refined.normals[i].dot(refined.normals[i - 1]), 0, 1e-9);
        }
    EXPECT_GT(pairs, 2.5 * positions);
    int off = 0;
    for (std::size_t i = 0; i < refined.points.size(); ++i)
        off += shapes::distance_to_box(refined.points[i], Vector(2, 2, 2)) > 1e-6;
    EXPECT_EQ(off, 0);
}

TEST(Creases, AreNotDividedMoreByRunsThanBySteps)
{
    OrientedSamples box = shapes::box(3500, Vector(2, 2, 2), 1);
    const auto on_edges = [](const Points& points)
    {
        return std::count_if(points.begin(), points.end(),
                             [](const Point& p)
                             {
                                 const auto on_faces = ((p.array().abs() - 1).abs() < 1e-9).count();
                                 return on_faces >= 2;
                             });
    };
    const PnRefinement at_once = refine_points(box, one_thread(4));
    for (int run = 0; run < 4; ++run)
    {
        const PnRefinement refined = refine_points(box, one_thread(1));
        EXPECT_EQ(refined.left_out, 0) << run;
        box.points.insert(box.points.end(), refined.points.begin(), refined.points.end());
        box.normals.insert(box.normals.end(), refined.normals.begin(), refined.normals.end());
    }
    EXPECT_LT(on_edges(box.points), 4 * on_edges(at_once.points));
}

} // namespace
