#include "one_thread.h"

#include "filter_pn_refine/refine.h"

#include "tests/shapes.h"

#include <recon/errors.h>
#include <recon/search/neighbours.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

namespace
{

using namespace recon;

OrientedSamples hemisphere(bool clean)
{
    const OrientedSamples sphere = shapes::sphere(3500, 1, 2);
    OrientedSamples half;
    for (const Point& p : sphere.points)
        if (p.z() >= 0)
        {
            half.points.push_back(p);
            half.normals.push_back(p.normalized());
        }
    for (int i = 0; clean && i < 105; ++i)
    {
        const double a = 2 * M_PI * i / 105;
        half.points.emplace_back(std::cos(a), std::sin(a), 0);
        half.normals.emplace_back(std::cos(a), std::sin(a), 0);
    }
    return half;
}

TEST(Boundaries, CleanRimIsRefinedAlongItsCircle)
{
    const OrientedSamples half = hemisphere(true);
    const PnRefinement refined = refine_points(half, one_thread(3));
    EXPECT_GE(refined.boundary_segments, 100);
    std::vector<double> angles;
    for (std::size_t i = 0; i < refined.points.size(); ++i)
    {
        const Point& p = refined.points[i];
        EXPECT_GT(p.z(), -1e-9);
        EXPECT_LT(std::abs(p.norm() - 1), 1e-4);
        EXPECT_GT(refined.normals[i].dot(p.normalized()), 0.999);
        if (p.z() < 1e-6)
            angles.push_back(std::atan2(p.y(), p.x()));
    }
    std::sort(angles.begin(), angles.end());
    EXPECT_GT(angles.size(), 700u);
    double widest = 0;
    for (std::size_t i = 1; i < angles.size(); ++i)
        widest = std::max(widest, angles[i] - angles[i - 1]);
    EXPECT_LT(widest, 0.2); // random points near the rim take a segment's place here and there
}

TEST(Boundaries, RaggedRimKeepsNormalsAndSpillsNowhere)
{
    const OrientedSamples half = hemisphere(false);
    const PnRefinement refined = refine_points(half, one_thread(4));
    EXPECT_GT(refined.points.size(), 20000u);
    for (std::size_t i = 0; i < refined.points.size(); ++i)
    {
        EXPECT_GT(refined.points[i].z(), 0);
        EXPECT_LT(std::abs(refined.points[i].norm() - 1), 5e-4);
        EXPECT_GT(refined.normals[i].dot(refined.points[i].normalized()), 0.999);
    }
}

TEST(Boundaries, NothingSpillsIntoAHoleWithARaggedRim)
{
    // From its rim points a hole is seen under less than half a turn, so that triangles could span it.
    for (const int seed : {1, 2, 3})
    {
        const OrientedSamples sphere = shapes::sphere(3500, 1, std::uint64_t(seed));
        OrientedSamples samples;
        for (std::size_t i = 0; i < sphere.points.size(); ++i)
            if (sphere.points[i].z() < 0.9)
            {
                samples.points.push_back(sphere.points[i]);
                samples.normals.push_back(sphere.normals[i]);
            }
        const PnRefinement refined = refine_points(samples, one_thread(3));
        EXPECT_GT(refined.points.size(), 15000u);
        for (const Point& p : refined.points)
            EXPECT_LT(p.z(), 0.903); // a twentieth of the spacing
    }
}

TEST(Holes, AreFilledSmoothlyOnDemandOnly)
{
    const OrientedSamples sphere = shapes::sphere(3500, 1, 2);
    OrientedSamples open;
    for (const Point& p : sphere.points)
        if (p.z() < 0.9)
        {
            open.points.push_back(p);
            open.normals.push_back(p.normalized());
        }
    const auto points_in_hole = [](const Points& points)
    { return std::count_if(points.begin(), points.end(), [](const Point& p) { return p.z() > 0.93; }); };
    PnRefineOptions options = one_thread(3);
    EXPECT_EQ(points_in_hole(refine_points(open, options).points), 0);
    options.hole_radius = 0.44;
    const PnRefinement filled = refine_points(open, options);
    EXPECT_GT(filled.hole_points, 50);
    for (std::size_t i = 0; i < filled.points.size(); ++i)
    {
        EXPECT_LT(std::abs(filled.points[i].norm() - 1), 0.02);
        EXPECT_GT(filled.normals[i].dot(filled.points[i].normalized()), 0.97);
    }
    Points all = open.points;
    all.insert(all.end(), filled.points.begin(), filled.points.end());
    const NeighbourSearch search(all);
    double gap = 0;
    for (const Point& p : shapes::sphere(20000, 1, 77).points)
        gap = std::max(gap, (all[std::size_t(search.nearest(p))] - p).norm());
    EXPECT_LT(gap, 3.5 * std::sqrt(12.566 / double(all.size())));
    options.max_points = int(open.points.size());
    EXPECT_EQ(refine_points(open, options).points.size(), 0u);
}

TEST(Holes, CanBeCancelledWhileTheyAreFilled)
{
    OrientedSamples open;
    for (const Point& p : shapes::sphere_below(0.8, 6000, 1, 2))
    {
        open.points.push_back(p);
        open.normals.push_back(p.normalized());
    }
    PnRefineOptions options = one_thread(1);
    options.hole_radius = 0.6;
    int calls = 0, stop = 1 << 30;
    double last = 0;
    const auto look = [&](double fraction, const std::string& phase)
    {
        EXPECT_GE(fraction, last);
        last = fraction;
        calls += phase == "holes";
        return calls < stop;
    };
    EXPECT_GT(refine_points(open, options, {}, Progress(look)).hole_points, 50);
    ASSERT_GT(calls, 30); // most of them from the refinement of few samples
    for (const int at : {3, calls / 2, calls - 2})
    {
        calls = 0;
        last = 0;
        stop = at;
        EXPECT_THROW(refine_points(open, options, {}, Progress(look)), Cancelled) << at;
        EXPECT_EQ(calls, at);
    }
}

TEST(Normals, FlippedOnesAreFoundAndTurned)
{
    OrientedSamples samples = shapes::torus(5000, 1, 0.4, 3);
    std::vector<int> flipped;
    for (int i = 17; i < 5000; i += 50)
    {
        flipped.push_back(i);
        samples.normals[std::size_t(i)] *= -1;
    }
    const PnRefinement refined = refine_points(samples, one_thread(2));
    EXPECT_EQ(refined.turned_normals, flipped);
    ASSERT_EQ(refined.warnings.size(), 1u);
    EXPECT_NE(refined.warnings[0].find("100 normals"), std::string::npos);
    for (const Point& p : refined.points)
        EXPECT_LT(shapes::distance_to_torus(p, 1, 0.4), 0.02);
}

TEST(Normals, ThinPlateKeepsBothSides)
{
    // Two sheets nearer to each other than their samples: opposite normals are right there.
    OrientedSamples plate;
    std::mt19937 random(4);
    std::uniform_real_distribution<double> u(-1, 1);
    for (int i = 0; i < 3000; ++i)
    {
        const double z = i % 2 ? 0.015 : -0.015;
        const Eigen::Vector2d place = shapes::draw_pair([&] { return u(random); });
        plate.points.emplace_back(place.x(), place.y(), z);
        plate.normals.emplace_back(0, 0, i % 2 ? 1 : -1);
    }
    const PnRefinement refined = refine_points(plate, one_thread(2));
    EXPECT_LT(refined.turned_normals.size(), 20u);
    // The edge is rounded; elsewhere nothing lies between the sheets.
    const auto off = std::count_if(refined.points.begin(), refined.points.end(),
                                   [](const Point& p) {
                                       return std::max(std::abs(p.x()), std::abs(p.y())) < 0.9 &&
                                              std::abs(std::abs(p.z()) - 0.015) > 1e-9;
                                   });
    EXPECT_LT(off, std::ptrdiff_t(refined.points.size() / 100));
}

} // namespace
