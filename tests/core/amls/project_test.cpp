#include "filter_amls/surface/project.h"

#include <recon/errors.h>

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

using namespace recon;

TEST(AmlsProjection, BringsFarPointsBack)
{
    const AmlsSurface surface = build_amls_surface(shapes::with_noise(shapes::sphere(8000, 1, 31).points, 0.005, 32));
    Points queries;
    for (const Point& p : shapes::sphere(500, 1, 33).points)
        queries.push_back(p * (queries.size() % 2 == 0 ? 1.15 : 0.85));
    AmlsProjectionOptions options;
    options.foreign_points = true;
    const AmlsProjection result = project_to_amls(queries, surface, options);
    for (const Point& p : result.points)
        EXPECT_LT(shapes::distance_to_sphere(p, 1), 0.01);
}

// Dense faces drew the points of a sparse wall beside them out of the solid, into the mouth of the bore.
TEST(AmlsProjection, DenseFacesDoNotDrawSparseWallsOut)
{
    const double side = 24, thickness = 10, radius = 7, noise = 0.5;
    Points points;
    int walls = 0;
    for (const Point& p : shapes::plate(side, thickness, {Point::Zero()}, 2 * radius, 1))
    {
        const bool is_face = std::abs(std::abs(p.z()) - 0.5 * thickness) < 1e-6;
        if (is_face || walls++ % 6 == 0)
            points.push_back(p);
    }
    points = shapes::with_noise(points, noise, 10);
    const auto distance = [&](const Point& p)
    {
        const double axis = p.head<2>().norm(), above = std::max(0.0, std::abs(p.z()) - 0.5 * thickness);
        const double bore = std::hypot(axis - radius, above);
        return axis < radius ? bore : std::min(bore, shapes::distance_to_box(p, Vector(side, side, thickness)));
    };
    const AmlsProjection result = project_to_amls(points, build_amls_surface(points));
    EXPECT_LT(shapes::rms(result.points, distance), 0.3); // 0.42 where these faces are heard
}

TEST(AmlsProjection, LeavesPointsThatAreTooFar)
{
    // Half a torus, so that some of what is far lies beside the sheet and in its plane.
    Points half;
    for (const Point& p : shapes::torus(20000, 1, 0.4, 49).points)
        if (p.x() > 0)
            half.push_back(p);
    const AmlsSurface surface = build_amls_surface(shapes::with_noise(half, 0.005, 50));
    AmlsProjectionOptions options;
    options.foreign_points = true;
    for (const double far : {3.0, 30.0, 1e9})
    {
        Points queries;
        for (const Point& p : shapes::sphere(500, 1, 51).points)
            queries.push_back(far * p);
        const AmlsProjection result = project_to_amls(queries, surface, options);
        EXPECT_EQ(result.count(ProjectionStatus::too_far), 500) << far;
        EXPECT_EQ(result.points, queries) << far;
    }
    // Nearer ones land on it, not on what would continue it.
    Points queries;
    for (const Point& p : shapes::sphere(2000, 1.6, 52).points)
        queries.push_back(p);
    const AmlsProjection result = project_to_amls(queries, surface, options);
    int landed = 0;
    for (std::size_t i = 0; i < queries.size(); ++i)
        if (result.status[i] == ProjectionStatus::converged)
        {
            ++landed;
            EXPECT_LT(shapes::distance_to_torus(result.points[i], 1, 0.4), 0.02);
            EXPECT_GT(result.points[i].x(), -0.3);
        }
    EXPECT_GT(landed, 200);
}

TEST(AmlsProjection, OutliersOfTheSurfaceHoldNoOtherPointsBack)
{
    Points points = shapes::with_noise(shapes::sphere(10000, 1, 53).points, 0.005, 54);
    for (const Point& p : shapes::sphere(200, 1, 55).points)
        points.push_back(1.25 * p);
    AmlsProjectionOptions options;
    options.foreign_points = true;
    Points queries;
    for (const Point& p : shapes::sphere(2000, 1.2, 56).points)
        queries.push_back(p);
    const AmlsProjection result = project_to_amls(queries, build_amls_surface(points), options);
    EXPECT_EQ(result.count(ProjectionStatus::too_far), 0);
    for (const Point& p : result.points)
        EXPECT_NEAR(p.norm(), 1, 0.02);
}

TEST(AmlsProjection, IsNearlyIdempotent)
{
    const Points points = shapes::with_noise(shapes::torus(8000, 1, 0.4, 34).points, 0.01, 35);
    const AmlsSurface surface = build_amls_surface(points);
    const AmlsProjection once = project_to_amls(points, surface);
    const AmlsProjection again = project_to_amls(once.points, surface);
    double squares = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
        squares += (again.points[i] - once.points[i]).squaredNorm();
    EXPECT_LT(std::sqrt(squares / double(points.size())), 2e-4);
}

TEST(AmlsProjection, RefusesBadOptions)
{
    const Points points = shapes::sphere(500, 1, 36).points;
    const AmlsSurface surface = build_amls_surface(points);
    const auto with = [&](auto change)
    {
        AmlsProjectionOptions options;
        change(options);
        return project_to_amls(points, surface, options);
    };
    EXPECT_THROW(with([](auto& o) { o.max_iterations = 0; }), InvalidInput);
    EXPECT_THROW(with([](auto& o) { o.tolerance = 0; }), InvalidInput);
    EXPECT_THROW(with([](auto& o) { o.cut_off = -1; }), InvalidInput);
    EXPECT_THROW(with([](auto& o) { o.threads = -1; }), InvalidInput);
    EXPECT_THROW(project_to_amls({Point(0, 0, std::numeric_limits<double>::infinity())}, surface), InvalidInput);
    EXPECT_TRUE(project_to_amls({}, surface).points.empty());
    EXPECT_THROW(project_to_amls(points, surface, {}, Progress([](double, const std::string&) { return false; })),
                 Cancelled);
}

namespace
{

/// Error with anchors that face elsewhere agreeing more closely, over that without.
double share_left_by_sharp(const Points& noisy, const std::function<double(const Point&)>& distance)
{
    const AmlsSurface surface = build_amls_surface(noisy);
    AmlsProjectionOptions smooth;
    smooth.sharp = false;
    return shapes::rms(project_to_amls(noisy, surface).points, distance) /
           shapes::rms(project_to_amls(noisy, surface, smooth).points, distance);
}

} // namespace

TEST(AmlsProjection, SharpErrsLessAtCreasesAndAsMuchElsewhere)
{
    const Vector sides(1, 0.18, 0.5);
    double mean = 0;
    for (const std::uint64_t seed : {45u, 47u, 49u, 51u})
    {
        const double share =
            share_left_by_sharp(shapes::with_noisy_copies(shapes::box(3000, sides, seed).points, 0.02, 4, seed + 1),
                                [&](const Point& p) { return shapes::distance_to_box(p, sides); });
        EXPECT_LT(share, 0.985) << seed;
        mean += share / 4;
    }
    EXPECT_LT(mean, 0.97);
    EXPECT_NEAR(share_left_by_sharp(shapes::with_noisy_copies(shapes::torus(3000, 1, 0.4, 53).points, 0.02, 4, 54),
                                    [](const Point& p) { return shapes::distance_to_torus(p, 1, 0.4); }),
                1, 0.01);
}

TEST(AmlsProjection, KeptFromTheResidualsIsWhatIsFoundAnew)
{
    const Points noisy = shapes::with_noisy_copies(shapes::box(3000, Vector(1, 0.18, 0.5), 45).points, 0.02, 4, 46);
    std::vector<Points> found;
    for (const bool sharp : {true, false})
    {
        AmlsOptions options;
        options.for_crust = !sharp;
        const AmlsSurface surface = build_amls_surface(noisy, options);
        AmlsProjectionOptions projection;
        projection.sharp = sharp;
        found.push_back(project_to_amls(noisy, surface, projection).points);
        projection.tolerance = std::nextafter(projection.tolerance, 1); // none like that is kept
        EXPECT_EQ(project_to_amls(noisy, surface, projection).points, found.back()) << sharp;
    }
    EXPECT_NE(found.front(), found.back());
}

TEST(AmlsProjection, FacesTheRightWayAtRims)
{
    // Where cells' normals lie across the rim: 1,182 are wrong with the cells' own sides.
    constexpr int n = 5000;
    int wrong = 0;
    for (const std::uint64_t seed : {1, 2})
    {
        const OrientedSamples lens = shapes::ellipsoid(n, Vector(1, 1, 0.12), seed);
        const Points points = shapes::with_noisy_copies(lens.points, 0.03, 4, seed + 5);
        const AmlsProjection moved = project_to_amls(points, build_amls_surface(points));
        for (std::size_t i = 0; i < points.size(); ++i)
            wrong += !(moved.normals[i].dot(lens.normals[i < n ? i : (i - n) / 4]) > 0);
    }
    EXPECT_LT(wrong, 1110);
}

TEST(AmlsProjection, FacesTheRightWayOnPlatesOfOneAndAHalfSpacings)
{
    // Where a landmark's balls weigh no more than those of one neighbour, .053 face the wrong way.
    constexpr int n = 5300;
    int wrong = 0;
    for (const std::uint64_t seed : {1, 2, 3})
    {
        const OrientedSamples plate = shapes::box(n, Vector(50, 50, 1.5), seed);
        const Points points = shapes::with_noise(plate.points, 0.2, seed + 5);
        const AmlsProjection moved = project_to_amls(points, build_amls_surface(points));
        for (std::size_t i = 0; i < points.size(); ++i)
            wrong += !(moved.normals[i].dot(plate.normals[i]) > 0);
    }
    EXPECT_LT(wrong, 0.035 * 3 * n);
}

TEST(AmlsProjection, LeavesBothSidesOfAThinPlateWhereTheyAre)
{
    // One sample a unit of area, noise of a tenth of the wall's thickness or more.
    const Vector sides(50, 50, 2);
    for (const double noise : {0.2, 0.3})
    {
        const Points plate = shapes::with_noise(shapes::box(5400, sides, 1).points, noise, 2);
        const AmlsSurface surface = build_amls_surface(plate);
        const AmlsProjection projected = project_to_amls(plate, surface);
        double before = 0, after = 0;
        int on_faces = 0, outward = 0;
        for (std::size_t i = 0; i < plate.size(); ++i)
        {
            before += std::pow(shapes::distance_to_box(plate[i], sides), 2);
            after += std::pow(shapes::distance_to_box(projected.points[i], sides), 2);
            if (plate[i].head<2>().cwiseAbs().maxCoeff() > 24)
                continue;
            ++on_faces;
            outward += projected.normals[i].z() * plate[i].z() > 0;
        }
        EXPECT_LT(std::sqrt(after / before), 0.85) << noise;
        EXPECT_GT(outward, 0.97 * on_faces) << noise;
    }
}
