#include "one_thread.h"

#include "filter_pn_refine/refine.h"

#include "tests/checks.h"
#include "tests/shapes.h"

#include <recon/search/neighbours.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

namespace
{

using namespace recon;

constexpr int plane_count = 5000;
const double plane_spacing = 2 / std::sqrt(double(plane_count));

/// Random points of a square of side 2 `scale` that lie farther than `hole` from its centre.
Points square(int count, double scale, double hole, std::uint32_t seed)
{
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> u(-scale, scale);
    Points points;
    for (int i = 0; i < count; ++i)
    {
        const Eigen::Vector2d p = shapes::draw_pair([&] { return u(random); });
        if (p.norm() > hole)
            points.emplace_back(p.x(), p.y(), 0);
    }
    return points;
}

OrientedSamples upward(const Points& points)
{
    return {points, Vectors(points.size(), Vector(0, 0, 1))};
}

OrientedSamples sphere_without_cap(double chord, std::uint64_t seed)
{
    OrientedSamples open;
    for (const Point& p : shapes::sphere(4000, 1, seed).points)
        if ((p - Point(0, 0, 1)).norm() > chord)
        {
            open.points.push_back(p);
            open.normals.push_back(p.normalized());
        }
    return open;
}

/// Largest distance of these from samples and new points.
double largest_distance(const Points& places, const OrientedSamples& samples, const PnRefinement& refined)
{
    Points all = samples.points;
    all.insert(all.end(), refined.points.begin(), refined.points.end());
    const NeighbourSearch search(all);
    double largest = 0;
    for (const Point& p : places)
        largest = std::max(largest, (all[std::size_t(search.nearest(p))] - p).norm());
    return largest;
}

PnRefinement fill(const OrientedSamples& samples, int steps, double hole_radius)
{
    PnRefineOptions options = one_thread(steps);
    options.hole_radius = hole_radius;
    return refine_points(samples, options);
}

TEST(Holes, OfAPlaneAreFilledAtEveryHoleRadiusAboveTheirs)
{
    for (const double spacings : {3.5, 5., 10.})
        for (const std::uint32_t seed : {1u, 2u})
        {
            const double r = spacings * plane_spacing;
            const OrientedSamples open = upward(square(plane_count, 1, r, seed));
            Points inside;
            for (const Point& p : square(4 * plane_count, 1, 0, 77))
                if (p.norm() < 0.95 * r)
                    inside.push_back(p);
            for (const double factor : {1., 2., 8.})
            {
                const PnRefinement filled = fill(open, 3, factor * r);
                EXPECT_GT(filled.hole_points, 4) << spacings << " " << seed << " " << factor;
                EXPECT_LT(largest_distance(inside, open, filled), 1.1 * plane_spacing)
                    << spacings << " " << seed << " " << factor;
                EXPECT_TRUE(filled.warnings.empty());
            }
        }
}

TEST(Holes, OfASphereAreFilledAtEveryHoleRadiusAboveTheirs)
{
    const double spacing = std::sqrt(4 * M_PI / 4000);
    for (const double chord : {3.5 * spacing, 5 * spacing, 10 * spacing, 0.8})
        for (const double factor : {1.5, 2., 8.})
        {
            const OrientedSamples open = sphere_without_cap(chord, 1);
            Points inside;
            for (const Point& p : shapes::sphere(20000, 1, 77).points)
                if ((p - Point(0, 0, 1)).norm() < 0.95 * chord)
                    inside.push_back(p);
            const PnRefinement filled = fill(open, 2, factor * chord);
            EXPECT_GT(filled.hole_points, 4) << chord << " " << factor;
            EXPECT_LT(largest_distance(inside, open, filled), 1.2 * spacing) << chord << " " << factor;
            for (const Point& p : filled.points)
                EXPECT_LT(std::abs(p.norm() - 1), 0.03);
        }
}

TEST(Holes, WiderThanTheHoleRadiusStayOpen)
{
    const double r = 10 * plane_spacing;
    for (const double factor : {0.35, 0.5, 0.7})
    {
        const PnRefinement refined = fill(upward(square(plane_count, 1, r, 1)), 0, factor * r);
        EXPECT_EQ(std::count_if(refined.points.begin(), refined.points.end(),
                                [&](const Point& p) { return p.norm() < 0.8 * r; }),
                  0);
        EXPECT_TRUE(checks::says(refined.warnings, "wider than the hole radius")) << factor;
    }
}

TEST(Holes, AreNotSeenWhereThereAreNone)
{
    OrientedSamples torus = shapes::torus(4000, 1, 0.4, 3);
    for (const double hole_radius : {0.1, 0.2, 0.4, 0.8})
    {
        EXPECT_LE(fill(sphere_without_cap(0, 1), 0, hole_radius).hole_points, 4) << hole_radius;
        EXPECT_LE(fill(upward(square(plane_count, 1, 0, 1)), 0, hole_radius).hole_points, 4) << hole_radius;
        EXPECT_LE(fill(torus, 0, hole_radius).hole_points, 4) << hole_radius;
    }
}

TEST(Holes, AreFilledAsDenselyAsTheSamplesAroundEach)
{
    // A patch a hundred times finer within a plane that has a hole elsewhere.
    Points points;
    for (const Point& p : square(2000, 1, 0, 1))
        if ((p - Point(0.5, 0.5, 0)).norm() > 0.25)
            points.push_back(p);
    const std::size_t coarse = points.size();
    for (const Point& p : square(20000, 0.01, 0, 2))
        points.push_back(p);
    const PnRefinement filled = fill(upward(points), 0, 0.4);
    EXPECT_LT(filled.hole_points, 2000);
    const auto in_hole = [](const Point& p) { return (p - Point(0.5, 0.5, 0)).norm() < 0.2; };
    const double expected = double(coarse) * M_PI * 0.04 / (4 - M_PI * 0.0625);
    const auto count = double(std::count_if(filled.points.begin(), filled.points.end(), in_hole));
    EXPECT_GT(count, 0.5 * expected);
    EXPECT_LT(count, 2 * expected);
}

TEST(Holes, NobodyIsLeftWonderingWhyNoneWasFilled)
{
    const double r = 10 * plane_spacing;
    const OrientedSamples open = upward(square(plane_count, 1, r, 1));
    const OrientedSamples intact = upward(square(plane_count, 1, 0, 1));
    EXPECT_TRUE(checks::says(fill(intact, 0, 0.2).warnings, "No hole was filled"));
    EXPECT_FALSE(checks::says(fill(open, 0, 1.5 * r).warnings, "hole"));
    EXPECT_FALSE(checks::says(fill(open, 0, 0).warnings, "hole"));
    PnRefineOptions options = one_thread(0);
    options.hole_radius = 1.5 * r;
    options.max_points = int(open.points.size()) + 10;
    EXPECT_TRUE(checks::says(refine_points(open, options).warnings, "largest number allowed"));
}

TEST(Holes, DoNotDependOnThreads)
{
    const OrientedSamples open = sphere_without_cap(0.6, 2);
    PnRefineOptions options = one_thread(1);
    options.hole_radius = 0.8;
    const PnRefinement one = refine_points(open, options);
    options.threads = 3;
    const PnRefinement three = refine_points(open, options);
    EXPECT_GT(one.hole_points, 50);
    EXPECT_EQ(one.points, three.points);
    EXPECT_EQ(one.parents, three.parents);
}

} // namespace
