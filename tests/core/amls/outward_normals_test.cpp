#include "filter_amls/normals/outward_normals.h"

#include "filter_amls/surface/project.h"
#include "project_all.h"
#include "tests/checks.h"
#include "tests/flat_shapes.h"
#include "tests/scans.h"
#include "tests/shapes.h"

#include <recon/errors.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace recon;

namespace
{

double mean_cosine(const Vectors& normals, const OrientedSamples& truth)
{
    double sum = 0;
    for (std::size_t i = 0; i < normals.size(); ++i)
        sum += normals[i].dot(truth.normals[i]);
    return sum / double(normals.size());
}

} // namespace

TEST(OutwardNormals, ThinWallsOfExactPointsFaceOutwardOnBothSides)
{
    const OrientedSamples tube = shapes::thin_tube(3);
    const OutwardNormals found = find_outward_normals(tube.points);
    EXPECT_TRUE(found.is_exact);
    EXPECT_GT(checks::share_facing(found.normals, tube.normals), 0.99);
    for (const Vector& n : found.normals)
        EXPECT_NEAR(n.norm(), 1, 1e-9);
}

// Whose cells mix both sides: half of the normals were wrong.
TEST(OutwardNormals, ThinWallsOfNoisyPointsFaceOutwardOnBothSides)
{
    const OrientedSamples tube = shapes::thin_tube(5);
    for (const double spacings : {0.05, 0.15})
    {
        const OutwardNormals found =
            find_outward_normals(shapes::with_noise(tube.points, spacings * shapes::thin_tube_spacing, 6));
        EXPECT_FALSE(found.is_exact);
        EXPECT_GT(checks::share_facing(found.normals, tube.normals), 0.9958) << spacings;
    }
}

// A few of which are like a surface without noise: .82 and .50 were right.
TEST(OutwardNormals, OfCopiesAlongNormalsFaceOutward)
{
    for (const int copies : {5, 15})
    {
        const OrientedSamples cloud = shapes::copies_along_normals(shapes::torus(4000, 1, 0.4, 7), 0.04, copies, 8);
        const OutwardNormals found = find_outward_normals(cloud.points);
        EXPECT_FALSE(found.is_exact) << copies;
        EXPECT_GT(checks::share_facing(found.normals, cloud.normals), 0.999) << copies;
    }
}

// Walls of 1.6 spacings read as noise, and the cloud as a solid: .58 were right.
TEST(OutwardNormals, WallsThatReadAsNoiseAreSoughtWithLessOfIt)
{
    constexpr int samples = 3000;
    constexpr double radius = 1, half_length = 1.5;
    const double spacing = std::sqrt(8 * 3.1416 * radius * half_length / samples);
    const OrientedSamples tube = shapes::tube(samples, radius, 1.6 * spacing, half_length, 719);
    const OutwardNormals found = find_outward_normals(shapes::with_noise(tube.points, 0.3 * spacing, 720));
    EXPECT_GT(checks::share_facing(found.normals, tube.normals), 0.95);
}

// As the vertices of a coarse model: the surface's cells mix both sides at the rim.
TEST(OutwardNormals, AreThoseOfTheCrustWhereExactPointsAreCoarse)
{
    const OrientedSamples lens = shapes::ellipsoid(400, {1, 0.5, 0.1}, 3);
    const OutwardNormals found = find_outward_normals(lens.points);
    EXPECT_TRUE(found.is_exact);
    EXPECT_EQ(checks::share_facing(found.normals, lens.normals), 1);
    EXPECT_GT(mean_cosine(found.normals, lens), 0.98);
    const Vectors of_surface = project_all(lens.points).normals;
    EXPECT_LT(checks::share_facing(of_surface, lens.normals), 0.99);
    EXPECT_LT(mean_cosine(of_surface, lens), 0.95);
}

// Its samples are told apart where the surface's cells mix both sides of the rim.
TEST(OutwardNormals, AreThoseOfTheCrustWhereNoisyPointsAreCoarse)
{
    for (const std::uint64_t seed : {3, 4, 5})
    {
        const OrientedSamples lens = shapes::ellipsoid(400, {1, 0.5, 0.1}, seed);
        OrientedSamples cloud{shapes::noisy_copies(lens.points, 0.005, 5, seed), {}};
        for (std::size_t i = 0; i < cloud.points.size(); ++i)
            cloud.normals.push_back(lens.normals[i % lens.normals.size()]);
        const OutwardNormals found = find_outward_normals(cloud.points);
        EXPECT_FALSE(found.is_exact);
        EXPECT_GT(found.of_crust, 0);
        const Vectors of_surface = project_all(cloud.points).normals;
        const auto share_wrong = [&](const Vectors& normals)
        { return 1 - checks::share_facing(normals, cloud.normals); };
        EXPECT_LT(share_wrong(found.normals), 0.1 * share_wrong(of_surface)) << seed;
        EXPECT_GT(mean_cosine(found.normals, cloud), mean_cosine(of_surface, cloud) + 0.02) << seed;
    }
}

// So few points read as an open sheet; half of them faced inward.
TEST(OutwardNormals, BodiesSoCoarseThatTheyReadAsOpenFaceOutward)
{
    for (const std::uint64_t seed : {3, 4})
    {
        const OrientedSamples lens = shapes::ellipsoid(200, {1, 0.5, 0.1}, seed);
        const OutwardNormals found = find_outward_normals(lens.points);
        EXPECT_FALSE(found.surface.open);
        EXPECT_GT(checks::share_facing(found.normals, lens.normals), 0.95);
    }
}

// A part whose faces carry samples on their rims only reads as open; normals lay 45 degrees off.
TEST(OutwardNormals, PartsOfBareFlatFacesThatReadAsOpenFaceOutward)
{
    const Points rims = flat_shapes::flange();
    const Points points = shapes::with_noisy_copies(rims, 0.0015, 4, 2);
    const OutwardNormals found = find_outward_normals(points);
    EXPECT_FALSE(found.surface.open);
    EXPECT_GT(found.of_crust, 0);
    int right = 0;
    double flatness = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
    {
        const double up = rims[i < rims.size() ? i : (i - rims.size()) / 4].z() > 0 ? 1 : -1;
        right += up * found.normals[i].z() > 0;
        flatness += std::abs(found.normals[i].z()) / double(points.size());
    }
    EXPECT_GT(right, 0.99 * double(points.size()));
    // Half way between face and wall.
    EXPECT_NEAR(flatness, std::sqrt(0.5), 0.05);
}

// Walls of 2.2 spacings whose crust is a solid ball that misses all points of the inside; the surface is right.
TEST(OutwardNormals, ACrustThatFillsWallsIsNotBelieved)
{
    OrientedSamples shell = shapes::sphere(5000, 0.9, 3);
    const OrientedSamples inside = shapes::sphere(4000, 0.8, 4);
    for (std::size_t i = 0; i < inside.points.size(); ++i)
    {
        shell.points.push_back(inside.points[i]);
        shell.normals.emplace_back(-inside.normals[i]);
    }
    const Vectors found = find_outward_normals(shapes::with_noise(shell.points, 0.25 * 0.045, 5)).normals;
    EXPECT_GT(checks::share_facing(found, shell.normals), 0.99);
}

// One of these samples is a vertex at which the crust is folded.
TEST(OutwardNormals, FoldsOfTheCrustHaveNoSay)
{
    const OrientedSamples ellipsoid = shapes::ellipsoid(3000, {1, 0.6, 0.3}, 2);
    EXPECT_EQ(checks::share_facing(find_outward_normals(ellipsoid.points).normals, ellipsoid.normals), 1);
}

TEST(OutwardNormals, AreAsCloseWhereTheSurfaceIsSmooth)
{
    const OrientedSamples torus = shapes::torus(3000, 1, 0.4, 7);
    const OutwardNormals found = find_outward_normals(torus.points);
    EXPECT_TRUE(found.is_exact);
    const Vectors smooth = project_all(torus.points).normals;
    for (std::size_t i = 0; i < smooth.size(); ++i)
        EXPECT_GT(found.normals[i].dot(torus.normals[i]), 0.9) << i;
    EXPECT_GT(mean_cosine(found.normals, torus), mean_cosine(smooth, torus) - 5e-5);
}

// The crust of points with so little noise is rough: an eighth of the normals was its own, and off by 30 degrees.
TEST(OutwardNormals, AreThoseOfTheSurfaceWhereExactPointsAreHardlyNoisy)
{
    const OrientedSamples torus = shapes::torus(5000, 1, 0.4, 4);
    constexpr double spacing = 0.056;
    for (const double noise : {0.01, 0.03, 0.05})
    {
        const OutwardNormals found = find_outward_normals(shapes::with_noise(torus.points, noise * spacing, 7));
        EXPECT_TRUE(found.is_exact) << noise;
        EXPECT_LT(found.of_crust, 0.03 * double(torus.points.size())) << noise;
        EXPECT_GT(mean_cosine(found.normals, torus), 0.993) << noise;
    }
}

// Beside its edges the surface is round, and the crust of so little noise is not.
TEST(OutwardNormals, AreThoseOfTheCrustBesideEdgesOfHardlyNoisyPoints)
{
    const OrientedSamples box = shapes::box(8000, {1.5, 1, 0.7}, 3);
    constexpr double spacing = 0.028;
    const Points points = shapes::with_noise(box.points, 0.01 * spacing, 4);
    const OutwardNormals found = find_outward_normals(points);
    EXPECT_TRUE(found.is_exact);
    EXPECT_GT(mean_cosine(found.normals, box), 0.989);
    EXPECT_LT(mean_cosine(project_all(points).normals, box), 0.987);
}

// Faces that close the hole lie across it.
TEST(OutwardNormals, AtTheRimOfAHoleAreThoseOfTheSurface)
{
    const OrientedSamples whole = shapes::ellipsoid(20000, {1, 0.8, 0.6}, 3);
    OrientedSamples open;
    for (std::size_t i = 0; i < whole.points.size(); ++i)
        if (whole.points[i].x() < 0.3)
        {
            open.points.push_back(whole.points[i]);
            open.normals.push_back(whole.normals[i]);
        }
    const OutwardNormals found = find_outward_normals(shapes::with_noise(open.points, 0.01, 4));
    EXPECT_FALSE(found.surface.open);
    OrientedSamples rim;
    Vectors at_rim;
    for (std::size_t i = 0; i < open.points.size(); ++i)
        if (open.points[i].x() > 0.285)
        {
            rim.normals.push_back(open.normals[i]);
            at_rim.push_back(found.normals[i]);
        }
    EXPECT_GT(mean_cosine(at_rim, rim), 0.997);
}

TEST(OutwardNormals, AreThoseOfTheSurfaceWherePointsAreNoisyOrOpen)
{
    const Points noisy = shapes::with_noise(shapes::torus(3000, 1, 0.4, 7).points, 0.02, 8);
    const Points open = shapes::sphere_below(-0.2, 3000, 1, 9);
    for (const Points& points : {noisy, open})
    {
        const OutwardNormals found = find_outward_normals(points);
        EXPECT_FALSE(found.is_exact);
        AmlsOptions options;
        options.for_labels = true;
        EXPECT_EQ(found.normals, project_to_amls(points, build_amls_surface(points, options)).normals);
    }
    EXPECT_TRUE(find_outward_normals(open).surface.open);
}

// The balls find the hollow sides inside: without a look for seams the two ends of an S, windings of a roll and bumps
// of a terrain whose plain passes for a ground faced either way (.50, .62 and .84 on one side).
// What a thin ring encloses is less than the error of the areas that its points stand for.
TEST(OutwardNormals, OfThinRingsPointOutward)
{
    for (const double noise : {0.0, 0.1})
        for (const double major : {30, 50})
        {
            const OrientedSamples ring = shapes::torus_of_rings(major, 1.5);
            const Vectors normals = find_outward_normals(shapes::with_noise(ring.points, noise, 101)).normals;
            EXPECT_GT(checks::share_facing(normals, ring.normals, 0.5), 0.99) << major << ' ' << noise;
        }
}

// The surface of points that look noisy everywhere has no sides.
TEST(OutwardNormals, OfThinTubesPointOutward)
{
    for (const double noise : {0.0, 0.05})
    {
        const OrientedSamples ring = shapes::torus_of_rings(30, 1);
        const Vectors normals = find_outward_normals(shapes::with_noise(ring.points, noise, 101)).normals;
        EXPECT_GT(checks::share_facing(normals, ring.normals, 0.5), 0.99) << noise;
    }
}

TEST(OutwardNormals, AreConsistentOnSheetsThatBendBack)
{
    for (const double noise : {0.0, 0.3})
    {
        const auto check = [&](const char* name, const OrientedSamples& sheet, double area)
        {
            const double sigma = noise * std::sqrt(area / double(sheet.points.size()));
            const OutwardNormals found = find_outward_normals(shapes::with_noise(sheet.points, sigma, 6));
            EXPECT_TRUE(found.surface.open) << name << noise;
            const double facing = checks::share_facing(found.normals, sheet.normals);
            EXPECT_GT(std::max(facing, 1 - facing), 0.99) << name << noise;
        };
        check("S", shapes::sheet(3000, shapes::s_sheet, 5), 6);
        check("S", shapes::sheet(10000, shapes::s_sheet, 5), 6);
        check("roll", shapes::sheet(10000, shapes::rolled_sheet, 5), 12);
        check("helicoid", shapes::sheet(10000, shapes::winding_sheet, 6), 2.5);
        check("terrain", shapes::sheet(40000, shapes::wavy_terrain(0.1, 6, 5), 5), 4.2);
    }
}

// A crust around the noise of a sheet has no lids either, but is no wall: .51 to .67 were on one side.
TEST(OutwardNormals, NoiseOfASheetIsNoThinWall)
{
    for (const std::uint64_t seed : {1, 3, 4})
    {
        const OrientedSamples sheet = shapes::sheet(3000, shapes::winding_sheet, seed);
        const OutwardNormals found =
            find_outward_normals(shapes::with_noise(sheet.points, 0.3 * std::sqrt(2.5 / 3000), seed + 1));
        EXPECT_TRUE(found.surface.open);
        const double facing = checks::share_facing(found.normals, sheet.normals);
        EXPECT_GT(std::max(facing, 1 - facing), 0.99) << seed;
    }
}

TEST(OutwardNormals, TakeNoPointsForExactWhereTheUserKnowsTheNoise)
{
    const OrientedSamples tube = shapes::thin_tube(3);
    AmlsOptions options;
    options.noise = 0.01;
    EXPECT_FALSE(find_outward_normals(tube.points, options).is_exact);
}

TEST(OutwardNormals, DoNotDependOnThreadsNorOnTheOrder)
{
    for (const double noise : {0.0, 0.1})
    {
        const Points points = shapes::with_noise(shapes::thin_tube(3).points, noise * shapes::thin_tube_spacing, 4);
        AmlsOptions options;
        options.threads = 1;
        const OutwardNormals once = find_outward_normals(points, options);
        EXPECT_GT(once.of_crust, 0);
        options.threads = 3;
        EXPECT_EQ(find_outward_normals(points, options).normals, once.normals);
        const Points reversed(points.rbegin(), points.rend());
        const Vectors turned = find_outward_normals(reversed, options).normals;
        EXPECT_EQ(Vectors(turned.rbegin(), turned.rend()), once.normals);
    }
}

TEST(OutwardNormals, RefuseFlatInputAndStopWhenAsked)
{
    EXPECT_THROW(find_outward_normals(Points(5, Point(1, 2, 3))), InvalidInput);
    for (const double share : {0.2, 0.55, 0.7, 0.9})
        EXPECT_THROW(find_outward_normals(shapes::thin_tube(3).points, {},
                                          Progress([&](double done, const std::string&) { return done < share; })),
                     Cancelled)
            << share;
}

TEST(OutwardNormals, OfADepthImageFaceItsCamera)
{
    for (const double step : {0.0005, 0.008})
    {
        const OrientedSamples frame = shapes::depth_frame(120, step, 4);
        const OutwardNormals found = find_outward_normals(frame.points);
        EXPECT_TRUE(found.surface.open);
        EXPECT_GT(checks::share_facing(found.normals, frame.normals), 0.98) << step;
    }
}

TEST(OutwardNormals, OfALaserScanFaceItsScanner)
{
    for (const bool in_room : {false, true})
        for (const double noise : {0.0, 0.01})
        {
            OrientedSamples scan = shapes::laser_scan(360, noise, in_room, 4);
            const OutwardNormals found = find_outward_normals(scan.points);
            EXPECT_EQ(found.surface.seen_from, Points{Point::Zero()}) << in_room << " " << noise;
            EXPECT_GT(checks::share_facing(found.normals, scan.normals), 0.98) << in_room << " " << noise;

            for (Point& p : scan.points)
                p += Vector(3, 2, 1);
            const OutwardNormals moved = find_outward_normals(scan.points);
            ASSERT_EQ(moved.surface.seen_from.size(), 1) << in_room << " " << noise;
            EXPECT_LT((moved.surface.seen_from[0] - Point(3, 2, 1)).norm(), 0.03) << in_room << " " << noise;
            EXPECT_GT(checks::share_facing(moved.normals, scan.normals), 0.98) << in_room << " " << noise;
        }
}

// Noise is along the rays, so the readings of a beam lie in its cone as if that were the surface: by it normals were
// 27, 54 and 51 degrees off, and of the third half faced the scanner.
TEST(OutwardNormals, OfAScannerOfFewBeamsAreThoseOfTheSurface)
{
    struct Beams
    {
        int around, stride;
        double noise, farthest;
    };
    for (const auto& [around, stride, noise, farthest] :
         {Beams{720, 8, 0.02, 6}, Beams{720, 12, 0.02, 6}, Beams{720, 20, 0.005, 10}})
    {
        const OrientedSamples scan = shapes::scan_by_beams(around, stride, noise, 3);
        const OutwardNormals found = find_outward_normals(scan.points);
        EXPECT_GT(checks::share_facing(found.normals, scan.normals), 0.998) << stride << " " << noise;
        EXPECT_LT(checks::mean_angle(found.normals, scan.normals), farthest) << stride << " " << noise;
    }
}

// The crust leaves its top out, since nobody saw it from below, and closes its shadow: by that .9974 and .9976 were
// right.
TEST(OutwardNormals, OfATableInARoomAreNotThoseOfItsShadow)
{
    const std::vector<Box> table = {{{0.8, -0.5, -0.8}, {1.6, 0.5, -0.75}}, {{1.15, -0.05, -1.5}, {1.25, 0.05, -0.8}}};
    for (const double noise : {0.0, 0.01})
    {
        const OrientedSamples scan = shapes::laser_scan(360, noise, true, 3, Point::Zero(), table);
        EXPECT_GT(checks::share_facing(find_outward_normals(scan.points).normals, scan.normals), 0.999) << noise;
    }
}

TEST(OutwardNormals, OfPointsOnTheirHullPointOutOfIt)
{
    for (const int around : {12, 36, 200})
    {
        Points cone{{0, 0, 1}};
        for (int i = 0; i < around; ++i)
            cone.emplace_back(0.5 * std::cos(2 * M_PI * i / around), 0.5 * std::sin(2 * M_PI * i / around), 0);
        const OutwardNormals found = find_outward_normals(cone);
        for (std::size_t i = 0; i < cone.size(); ++i)
            EXPECT_GE(found.normals[i].dot(cone[i] - Point(0, 0, 0.25)), 0) << around << " " << i;
    }
}

TEST(OutwardNormals, OfSeveralScansFaceTheScannerOfEach)
{
    for (const bool in_room : {false, true})
    {
        const OrientedSamples scans = shapes::laser_scans(300, 0.005, in_room, 4, {{1.5, 2, 0.5}, {-1, 1.5, 0.2}});
        const OutwardNormals found = find_outward_normals(scans.points);
        EXPECT_EQ(found.surface.seen_from.size(), 2) << in_room;
        EXPECT_GT(checks::share_facing(found.normals, scans.normals), 0.98) << in_room;
    }
}

// Between which the surface weaves, with the noise of each: of the first .61 faced outward, of the second .98.
TEST(OutwardNormals, ViewsOutOfRegisterFaceOutward)
{
    for (const int seed : {2, 4})
    {
        const OrientedSamples seen = shapes::torus_out_of_register(seed);
        const OutwardNormals found = find_outward_normals(seen.points);
        EXPECT_TRUE(found.lies_between_sheets) << seed;
        EXPECT_GT(checks::share_facing(found.normals, seen.normals), 0.998) << seed;
    }
}
