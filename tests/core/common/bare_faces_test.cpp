#include <recon/bare_faces/bare_faces.h>

#include "tests/flat_shapes.h"
#include "tests/shapes.h"

#include <recon/errors.h>
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
    const BareFaces faces = fill_bare_faces(corners.points, corners.normals, 1);
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
    const BareFaces faces = fill_bare_faces(torus.points, torus.normals, 1);
    EXPECT_LT(faces.contradicted, 0.01);
    EXPECT_LT(faces.share, 0.1);
}

TEST(BareFaces, AreTheSameForAnyNumberOfThreads)
{
    const OrientedSamples corners = in_spatial_order(rounded_corners());
    const BareFaces one = fill_bare_faces(corners.points, corners.normals, 1),
                    three = fill_bare_faces(corners.points, corners.normals, 3);
    EXPECT_EQ(one.points, three.points);
    EXPECT_EQ(one.normals, three.normals);
}

TEST(BareFaces, StopWhenAsked)
{
    const OrientedSamples corners = in_spatial_order(rounded_corners());
    EXPECT_THROW(
        fill_bare_faces(corners.points, corners.normals, 1, Progress([](double, const std::string&) { return false; })),
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
