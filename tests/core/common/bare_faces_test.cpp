#include <recon/bare_faces/bare_faces.h>

#include "tests/flat_shapes.h"
#include "tests/shapes.h"

#include <recon/errors.h>
#include <recon/search/block_search.h>
#include <recon/search/spatial_order.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace recon;
using namespace flat_shapes;

namespace
{

OrientedSamples in_spatial_order(const OrientedSamples& samples)
{
    const std::vector<int> order = order_input(samples.points).order;
    return {points_at(order, samples.points), points_at(order, samples.normals)};
}

LabelledBalls label(const Points& samples, const Vectors& normals, double most_violated)
{
    PhaseTimes times;
    return label_polar_balls(samples, normals, BallLabellingOptions{}.within(most_violated), times);
}

/// A ball of radius 0.5 without what lies above z = `top`.
OrientedSamples cut_ball(double top)
{
    const OrientedSamples ball = in_spatial_order(shapes::sphere(4000, 0.5, 3));
    OrientedSamples result;
    for (std::size_t i = 0; i < ball.points.size(); ++i)
        if (ball.points[i].z() < top)
        {
            result.points.push_back(ball.points[i]);
            result.normals.push_back(ball.normals[i]);
        }
    return result;
}

/// What label_with_bare_faces() adds if the crust without violates so many votes [count].
int added_if(double violated, const OrientedSamples& samples, bool are_sheet)
{
    PhaseTimes times;
    const auto found = label_with_bare_faces(
        samples.points.size(), violated,
        [&] {
            return SamplesOfFaces{samples, are_sheet};
        },
        label, times, 1);
    if (!found)
        return 0;
    EXPECT_EQ(found->samples.size(), samples.points.size() + std::size_t(found->added));
    EXPECT_EQ(found->normals.size(), found->samples.size());
    return found->added;
}

} // namespace

TEST(BareFaces, AreFilledBetweenRoundedCorners)
{
    const OrientedSamples corners = in_spatial_order(rounded_corners());
    const BareFaces faces = fill_bare_faces(corners.points, corners.normals, {}, 1);
    EXPECT_LT(faces.contradicted, 0.01);
    EXPECT_GT(faces.share, 0.8);
    ASSERT_GT(faces.points.size(), 200u);
    ASSERT_EQ(faces.points.size(), faces.normals.size());
    for (std::size_t i = 0; i < faces.points.size(); ++i)
    {
        EXPECT_NEAR(distance_to_rounded_box(faces.points[i]), 0, 0.002);
        const Point before = faces.points[i] + 0.01 * faces.normals[i];
        EXPECT_GT(distance_to_rounded_box(before), 0.005);
        EXPECT_NEAR(faces.normals[i].norm(), 1, 1e-12);
    }
}

TEST(BareFaces, FewAreBareInRandomSamples)
{
    const OrientedSamples torus = in_spatial_order(shapes::torus(3000, 0.35, 0.12, 2));
    const BareFaces faces = fill_bare_faces(torus.points, torus.normals, {}, 1);
    EXPECT_LT(faces.contradicted, 0.01);
    EXPECT_LT(faces.share, 0.1);
}

TEST(BareFaces, AreTheSameForAnyNumberOfThreads)
{
    const OrientedSamples corners = in_spatial_order(rounded_corners());
    const BareFaces one = fill_bare_faces(corners.points, corners.normals, {}, 1),
                    three = fill_bare_faces(corners.points, corners.normals, {}, 3);
    EXPECT_EQ(one.points, three.points);
    EXPECT_EQ(one.normals, three.normals);
}

TEST(BareFaces, AreNotFilledUnlessWanted)
{
    const OrientedSamples torus = in_spatial_order(shapes::torus(3000, 0.35, 0.12, 2));
    EXPECT_GT(fill_bare_faces(torus.points, torus.normals, {}, 1).pieces, 1000u);
    const BareFaces few = fill_bare_faces(torus.points, torus.normals, {0.1, 1}, 1);
    EXPECT_FALSE(few.are_wanted);
    EXPECT_EQ(few.pieces, 0u);
    EXPECT_TRUE(few.points.empty());
    OrientedSamples corners = in_spatial_order(rounded_corners());
    for (std::size_t i = 0; i < corners.normals.size(); i += 8)
        corners.normals[i] = -corners.normals[i];
    const BareFaces contradicted = fill_bare_faces(corners.points, corners.normals, {0, 0.05}, 1);
    EXPECT_FALSE(contradicted.are_wanted);
    EXPECT_EQ(contradicted.pieces, 0u);
}

TEST(BareFaces, SliversBesideEachOtherAreNotAllDivided)
{
    // From each sample of a rim to places far off: each four hundred pieces and more, side by side.
    constexpr double height = 0.6, radius = 0.4;
    OrientedSamples rims;
    for (const double up : {-1.0, 1.0})
    {
        Points ring;
        append_ring(ring, 0, 0, 0.5 * up * height, radius, 2500);
        for (const Point& p : ring)
        {
            rims.points.push_back(p);
            rims.normals.push_back(Vector(p.x(), p.y(), up * radius).normalized());
        }
    }
    rims = in_spatial_order(rims);
    const BareFaces faces = fill_bare_faces(rims.points, rims.normals, {}, 1);
    EXPECT_TRUE(faces.are_wanted);
    EXPECT_GT(faces.pieces, 250 * rims.points.size()); // more than without
    EXPECT_LT(faces.pieces, 600 * rims.points.size());
    // None is missing all the same.
    const BlockSearch search(points_at(order_input(faces.points).order, faces.points));
    int lids = 0, walls = 0;
    for (double x = -0.3; x < 0.31; x += 0.05)
        for (double y = -0.2; y < 0.21; y += 0.05)
            lids += search.has_within(Point(x, y, 0.5 * height), 0.3 * (radius - std::hypot(x, y)), 1);
    for (double angle = 0; angle < 6.2; angle += 0.1)
        for (double z = -0.2; z < 0.21; z += 0.1)
            walls += search.has_within(Point(radius * std::cos(angle), radius * std::sin(angle), z),
                                       0.4 * (0.5 * height - std::abs(z)), 1);
    EXPECT_EQ(lids, 13 * 9);
    EXPECT_EQ(walls, 63 * 5);
}

TEST(BareFaces, RowWithSamplesBesideItTakesNoMoreThanOthers)
{
    // All slivers meet in the two samples off it.
    OrientedSamples row;
    for (int i = 0; i < 1500; ++i)
        row.points.emplace_back(i < 2 ? 0 : i / 1500.0, i == 0 ? 0.1 : 0, i == 1 ? 0.1 : 0);
    row.normals.assign(row.points.size(), Vector(0, -1, -1).normalized());
    row.normals[0] = Vector::UnitY();
    row.normals[1] = Vector::UnitZ();
    row = in_spatial_order(row);
    const BareFaces faces = fill_bare_faces(row.points, row.normals, {}, 1);
    EXPECT_LE(faces.pieces, (250 + 750) * row.points.size() + 2);
}

TEST(BareFaces, StopWhenAsked)
{
    const OrientedSamples corners = in_spatial_order(rounded_corners());
    EXPECT_THROW(fill_bare_faces(corners.points, corners.normals, {}, 1,
                                 Progress([](double, const std::string&) { return false; })),
                 Cancelled);
}

TEST(LabelWithBareFaces, AsksOnlyWhereVotesObjectAndLeavesFewer)
{
    const OrientedSamples corners = in_spatial_order(rounded_corners());
    EXPECT_GT(added_if(0.02, corners, false), 0);
    EXPECT_EQ(added_if(0.009, corners, false), 0);
    // Where nothing is bare.
    EXPECT_EQ(added_if(0.02, in_spatial_order(shapes::torus(3000, 0.35, 0.12, 2)), false), 0);
}

TEST(LabelWithBareFaces, BelievesNormalsOnlyIfTheyAgree)
{
    OrientedSamples corners = in_spatial_order(rounded_corners());
    for (std::size_t i = 0; i < corners.normals.size(); i += 8)
        corners.normals[i] = -corners.normals[i];
    EXPECT_EQ(added_if(0.5, corners, false), 0);
}

TEST(LabelWithBareFaces, PutsNoLidsOnOpenSheets)
{
    // Most of the boundary is bare here, but not here.
    EXPECT_GT(added_if(0.02, in_spatial_order(rounded_corners()), true), 0);
    EXPECT_EQ(added_if(0.5, cut_ball(0), true), 0);
    EXPECT_GT(added_if(0.5, cut_ball(0), false), 0);
}

TEST(LabelWithBareFaces, ClosesNoSmallerHoles)
{
    EXPECT_EQ(added_if(0.5, cut_ball(0.3), false), 0);
}
