#include "filter_amls/sides/orient.h"

#include <recon/errors.h>

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace recon;

namespace
{

/// As landmarks come: normals off by some degrees, their signs at random.
struct Landmarks
{
    Points points;
    Vectors truth, given;
    std::vector<double> spacing;

    void add(const OrientedSamples& samples, double spacing_of_these, const Vector& shift = Vector::Zero(),
             bool inward = false)
    {
        for (std::size_t i = 0; i < samples.points.size(); ++i)
        {
            points.push_back(samples.points[i] + shift);
            truth.push_back(inward ? Vector(-samples.normals[i]) : samples.normals[i]);
            const Vector off = shapes::draw_vector([&] { return uniform(); });
            given.push_back((uniform() < 0 ? -1.0 : 1.0) * (truth.back() + 0.2 * off).normalized());
            spacing.push_back(spacing_of_these);
        }
    }
    void scale(double factor)
    {
        for (Point& p : points)
            p *= factor;
        for (double& s : spacing)
            s *= factor;
    }
    Orientation orient(int threads = 1) const { return orient_normals(points, given, spacing, threads); }
    int wrong(const Orientation& found) const
    {
        int count = 0;
        for (std::size_t i = 0; i < points.size(); ++i)
            count += !(found.normals[i].dot(truth[i]) > 0);
        return count;
    }

private:
    double uniform() { return 2 * shapes::uniform(random_) - 1; }
    shapes::Random random_{11};
};

/// Fibonacci's: thin, as landmarks are.
OrientedSamples even_sphere(int n, double radius)
{
    OrientedSamples samples;
    for (int i = 0; i < n; ++i)
    {
        const double z = 1 - (2 * i + 1) / double(n), r = std::sqrt(1 - z * z), angle = i * M_PI * (3 - std::sqrt(5));
        samples.normals.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
        samples.points.push_back(radius * samples.normals.back());
    }
    return samples;
}

double sphere_spacing(int n, double radius)
{
    return radius * std::sqrt(4 * M_PI / n);
}

} // namespace

TEST(OrientNormals, PointOutwardWhateverTheirSignsWere)
{
    Landmarks torus;
    torus.add(shapes::torus(4000, 1, 0.3, 1), std::sqrt(4 * M_PI * M_PI * 0.3 / 4000));
    torus.scale(0.3);
    const Orientation found = torus.orient();
    EXPECT_EQ(torus.wrong(found), 0);
    EXPECT_LT(found.contradicted, 0.02);
    EXPECT_FALSE(found.open);
    // Only the signs change, and what signs were given does not matter.
    for (std::size_t i = 0; i < torus.points.size(); ++i)
        EXPECT_EQ(found.normals[i].cwiseAbs(), torus.given[i].cwiseAbs());
    Landmarks turned = torus;
    for (Vector& n : turned.given)
        n = -n;
    EXPECT_EQ(turned.orient().normals, found.normals);
    EXPECT_EQ(torus.orient(3).normals, found.normals);
}

TEST(OrientNormals, PolesLieOnTheMedialAxis)
{
    Landmarks torus;
    torus.add(shapes::torus(4000, 1, 0.3, 1), std::sqrt(4 * M_PI * M_PI * 0.3 / 4000));
    torus.scale(0.3);
    const Orientation found = torus.orient();
    int within = 0, on_circle = 0;
    for (const Point& p : found.poles)
    {
        const double from_circle = std::hypot(std::hypot(p.x(), p.y()) - 0.3, p.z());
        within += from_circle < 0.09;
        on_circle += from_circle < 0.02;
    }
    EXPECT_GT(within, 500);
    EXPECT_GT(on_circle, 0.9 * within);
}

TEST(OrientNormals, FaceAwayFromTheWallOfAHollow)
{
    // The wall is four spacings thick; the inner sphere faces its centre.
    Landmarks shell;
    const int n = 6000, m = int(0.64 * n);
    shell.add(even_sphere(n, 1), sphere_spacing(n, 1));
    shell.add(even_sphere(m, 0.8), sphere_spacing(m, 0.8), Vector::Zero(), true);
    shell.scale(0.3);
    EXPECT_EQ(shell.wrong(shell.orient()), 0);
}

TEST(OrientNormals, FaceTheGapBetweenNearBodies)
{
    // Three spacings apart where they are nearest: balls between them are small.
    Landmarks pair;
    const int n = 4000;
    const double spacing = sphere_spacing(n, 1);
    pair.add(even_sphere(n, 1), spacing);
    pair.add(even_sphere(n, 1), spacing, Vector(2 + 3 * spacing, 0, 0));
    pair.scale(0.2);
    EXPECT_EQ(pair.wrong(pair.orient()), 0);
}

TEST(OrientNormals, FaceOutwardOnThinPlates)
{
    // Two and a half spacings thick: every inner ball is small.
    const Vector sides(50, 50, 2.5);
    Landmarks plate;
    plate.add(shapes::box(5500, sides, 3), 1);
    plate.scale(0.01);
    EXPECT_LT(plate.wrong(plate.orient()), 0.01 * 5500);
}

TEST(OrientNormals, AgreeWithTheirNeighboursOnARoughCloud)
{
    // What noise is left is a third of the spacing, so that many a ball lies between the samples.
    const int n = 6000;
    const double spacing = std::sqrt(4 * M_PI * M_PI * 0.3 / n);
    OrientedSamples rough = shapes::torus(n, 1, 0.3, 5);
    rough.points = shapes::with_noise(rough.points, 0.35 * spacing, 6);
    Landmarks torus;
    torus.add(rough, spacing);
    torus.scale(0.3);
    const int wrong = torus.wrong(torus.orient());
    EXPECT_LE(wrong, 5);
}

TEST(OrientNormals, TrustBallsAsFarAsTheyAreLargerThanTheSpacing)
{
    // So rough that balls between the samples are as many as others; were they trusted as well, 83 would err, and 17 if
    // balls of half the size were trusted fully.
    const int n = 6000;
    const double spacing = std::sqrt(4 * M_PI * M_PI * 0.3 / n);
    int wrong = 0;
    for (const std::uint64_t seed : {1, 2, 3})
    {
        OrientedSamples rough = shapes::torus(n, 1, 0.3, seed);
        rough.points = shapes::with_noise(rough.points, 0.7 * spacing, seed + 5);
        Landmarks torus;
        torus.add(rough, spacing);
        torus.scale(0.3);
        wrong += torus.wrong(torus.orient());
    }
    EXPECT_LE(wrong, 5);
}

TEST(OrientNormals, WhatReachesOutIsOutsideWhateverAPlateSays)
{
    // One spacing thick and rough: many a landmark has its poles above and below the plate, whose number would outvote
    // a tie of some weight between the outermost balls and the outside; then half of the plate faces inward, in each of
    // the six.
    constexpr int n = 5200;
    int right = 0;
    for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6})
    {
        Landmarks plate;
        OrientedSamples rough = shapes::box(n, Vector(50, 50, 1), seed);
        rough.points = shapes::with_noise(rough.points, 0.15, seed + 10);
        plate.add(rough, 1);
        plate.scale(0.01);
        right += plate.wrong(plate.orient()) < 0.01 * n;
    }
    EXPECT_GE(right, 4);
}

TEST(OrientNormals, ListenToNeighboursOfTheirOwnSheet)
{
    // Two spacings thick and rough: among the neighbours of a landmark are as many of the other side, which rightly
    // contradict it: were they all listened to, 76 would err, and 52 do.
    const Vector sides(50, 50, 2);
    int wrong = 0;
    for (const std::uint64_t seed : {1, 2, 3})
    {
        Landmarks plate;
        OrientedSamples rough = shapes::box(5400, sides, seed);
        rough.points = shapes::with_noise(rough.points, 0.3, seed + 10);
        plate.add(rough, 1);
        plate.scale(0.01);
        wrong += plate.wrong(plate.orient());
    }
    EXPECT_LT(wrong, 60);
}

TEST(OrientNormals, DoNotSlipThroughHoles)
{
    // Round holes of ten spacings, through which balls of the outside reach in.
    const int n = 8000;
    const double spacing = sphere_spacing(n, 1);
    const OrientedSamples all = even_sphere(n, 1);
    const Points holes = even_sphere(10, 1).points;
    OrientedSamples left;
    for (std::size_t i = 0; i < all.points.size(); ++i)
        if (std::none_of(holes.begin(), holes.end(),
                         [&](const Point& hole) { return (all.points[i] - hole).norm() < 5 * spacing; }))
        {
            left.points.push_back(all.points[i]);
            left.normals.push_back(all.normals[i]);
        }
    Landmarks holed;
    holed.add(left, spacing);
    holed.scale(0.3);
    const Orientation found = holed.orient();
    EXPECT_EQ(holed.wrong(found), 0);
    EXPECT_FALSE(found.open);
}

TEST(OrientNormals, AreConsistentOnAnOpenSheet)
{
    const int n = 8000;
    const OrientedSamples all = even_sphere(n, 1);
    OrientedSamples bowl;
    for (std::size_t i = 0; i < all.points.size(); ++i)
        if (all.points[i].z() < -0.2)
        {
            bowl.points.push_back(all.points[i]);
            bowl.normals.push_back(all.normals[i]);
        }
    Landmarks sheet;
    sheet.add(bowl, sphere_spacing(n, 1));
    sheet.scale(0.3);
    const Orientation found = sheet.orient();
    EXPECT_TRUE(found.open);
    const int wrong = sheet.wrong(found);
    EXPECT_LT(std::min(wrong, int(bowl.points.size()) - wrong), 5);
}

// Its sides were not seen: air below it, and a tent from its rim to that of the floor, would spare the labels large
// gaps.
TEST(OrientNormals, FaceUpOnATableOverAFloor)
{
    Landmarks scene;
    scene.add(shapes::table_over_a_floor(4), 1);
    scene.scale(0.01);
    const Orientation found = scene.orient();
    EXPECT_TRUE(found.open);
    EXPECT_LT(scene.wrong(found), int(scene.points.size() / 50));
    const Orientation same = scene.orient(3);
    for (std::size_t i = 0; i < scene.points.size(); ++i)
        EXPECT_EQ(found.normals[i], same.normals[i]);
}

// Its labels may take the air between them for the inside, which reaches out to the box on that side.
TEST(OrientNormals, ABallBesideAFloorFacesOutwardAndTheFloorFacesIt)
{
    for (const double x : {45, 60, 80})
        for (const double z : {17, 30})
            for (const std::uint64_t seed : {4, 5, 6})
            {
                Landmarks scene;
                scene.add(shapes::ball_apart_from_a_floor({x, 5, z}, 9, seed), 1);
                scene.scale(0.01);
                const Orientation found = scene.orient();
                EXPECT_TRUE(found.open);
                EXPECT_EQ(scene.wrong(found), 0) << x << " " << z;
                for (std::size_t i = 0; i < scene.points.size(); ++i)
                    EXPECT_EQ(found.is_closed[i], i < scene.points.size() - 101 * 101) << x << " " << z;
            }
}

TEST(OrientNormals, ATubeBesideAFloorIsNotClosed)
{
    OrientedSamples tube;
    for (double z = 20; z < 50; ++z)
        for (int k = 0; k < 50; ++k)
        {
            const Vector away(std::cos(2 * M_PI * k / 50), std::sin(2 * M_PI * k / 50), 0);
            tube.points.push_back(Point(60, 0, z) + 8 * away);
            tube.normals.push_back(away);
        }
    Landmarks scene;
    scene.add(shapes::ball_apart_from_a_floor({0, 0, 200}, 1, 4), 1); // the ball is too small to matter
    scene.add(tube, 1);
    scene.scale(0.01);
    const Orientation found = scene.orient();
    ASSERT_TRUE(found.open);
    EXPECT_EQ(std::count(found.is_closed.end() - std::ptrdiff_t(tube.points.size()), found.is_closed.end(), 1), 0);
}

// Its own volume tells, though the ball is behind it.
TEST(OrientNormals, ADomeOverABallFacesOutward)
{
    for (const std::uint64_t seed : {4, 5, 6})
    {
        const OrientedSamples all = even_sphere(5000, 20);
        OrientedSamples dome;
        for (std::size_t i = 0; i < all.points.size(); ++i)
            if (all.points[i].z() > 6)
            {
                dome.points.push_back(all.points[i]);
                dome.normals.push_back(all.normals[i]);
            }
        Landmarks scene;
        scene.add(dome, 1);
        scene.add(shapes::sphere(314, 5, seed), 1);
        scene.scale(0.01);
        const Orientation found = scene.orient();
        ASSERT_TRUE(found.open);
        EXPECT_EQ(scene.wrong(found), 0) << seed;
    }
}

TEST(OrientNormals, CanBeCancelled)
{
    Landmarks sphere;
    sphere.add(even_sphere(500, 0.3), sphere_spacing(500, 0.3));
    EXPECT_THROW(orient_normals(sphere.points, sphere.given, sphere.spacing, 1,
                                Progress([](double, const std::string&) { return false; })),
                 Cancelled);
}
