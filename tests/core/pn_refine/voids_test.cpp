#include "one_thread.h"

#include "filter_pn_refine/refine.h"

#include "tests/shapes.h"

#include <recon/search/neighbours.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace
{

using namespace recon;

/// Of a sphere with the density 10^-(z + 1): 100 times as dense at one pole as at the other.
OrientedSamples uneven_sphere(std::uint64_t seed)
{
    shapes::Random random(5);
    OrientedSamples kept;
    const OrientedSamples even = shapes::sphere(60000, 1, seed);
    for (std::size_t i = 0; i < even.points.size(); ++i)
        if (shapes::uniform(random) < std::pow(10, -(even.points[i].z() + 1)))
        {
            kept.points.push_back(even.points[i]);
            kept.normals.push_back(even.normals[i]);
        }
    return kept;
}

/// Largest distance from a point of the surface to the cloud, times the square root of the density there.
template <class Density>
double largest_gap(const Points& surface, Points cloud, const PnRefinement& refined, const Density& density)
{
    cloud.insert(cloud.end(), refined.points.begin(), refined.points.end());
    const NeighbourSearch search(cloud);
    double largest = 0;
    for (const Point& p : surface)
        largest = std::max(largest, std::sqrt(density(p) * double(cloud.size())) *
                                        (cloud[std::size_t(search.nearest(p))] - p).norm());
    return largest;
}

TEST(Voids, StayWhereTheUserSetsLimits)
{
    const OrientedSamples sphere = shapes::sphere(500, 1, 11);
    EXPECT_GT(refine_points(sphere, one_thread(1)).void_points, 0);
    PnRefineOptions few = one_thread(1), given = one_thread(1), target = one_thread(1);
    few.max_points = 500;
    given.initial_radius = 2;
    target.target_radius = 2;
    for (const PnRefineOptions& options : {few, given, target})
        EXPECT_EQ(refine_points(sphere, options).void_points, 0);
    EXPECT_EQ(refine_points(sphere, one_thread(0)).points.size(), 0u);
}

TEST(Voids, LeaveNoGapAfterTheFirstStep)
{
    // Without samples in them 1.88 spacings are left on this sphere, and 1.7 in the mean of these ten tori.
    const OrientedSamples uneven = uneven_sphere(2);
    const PnRefinement refined = refine_points(uneven, one_thread(1));
    EXPECT_GT(refined.void_points, 0);
    EXPECT_LT(largest_gap(shapes::sphere(100000, 1, 99).points, uneven.points, refined,
                          [](const Point& p)
                          { return std::pow(10, -(p.z() + 1)) * 2 * std::log(10.0) / 0.99 / (4 * M_PI); }),
              1.6);

    const Points torus = shapes::torus(100000, 1, 0.4, 99).points;
    double mean = 0; // of one the order of the samples decides
    for (std::uint64_t seed = 1; seed <= 10; ++seed)
    {
        const OrientedSamples samples = shapes::torus(3500, 1, 0.4, seed);
        mean += 0.1 * largest_gap(torus, samples.points, refine_points(samples, one_thread(1)),
                                  [](const Point&) { return 1 / (4 * M_PI * M_PI * 0.4); });
    }
    EXPECT_LT(mean, 1.65);
}

TEST(Voids, AreTheSameForAnyNumberOfThreads)
{
    const OrientedSamples samples = uneven_sphere(3);
    PnRefineOptions options = one_thread(1);
    const PnRefinement one = refine_points(samples, options);
    options.threads = 3;
    const PnRefinement three = refine_points(samples, options);
    EXPECT_GT(one.void_points, 0);
    EXPECT_EQ(one.points, three.points);
    EXPECT_EQ(one.normals, three.normals);
    EXPECT_EQ(one.parents, three.parents);
}

TEST(Voids, NoneIsFoundWhereSamplesLieEvenlyNorAcrossARim)
{
    for (int width = 0; width <= 6; ++width)
    {
        // On an exact grid rounding decides which way its squares are divided.
        shapes::Random random(1);
        const auto jitter = [&] { return 1e-3 * shapes::uniform(random); };
        OrientedSamples grid;
        for (int x = 0; x < 40; ++x)
            for (int y = 0; y < 40; ++y)
            {
                if (x < 8 && y >= 18 && y < 18 + width) // a bay
                    continue;
                const Eigen::Vector2d place = Eigen::Vector2d(x, y) + shapes::draw_pair(jitter);
                grid.points.emplace_back(place.x(), place.y(), 0);
                grid.normals.push_back(Vector::UnitZ());
            }
        // Some at the end of a wide one.
        EXPECT_LE(refine_before_steps(grid).void_points, width < 5 ? 0 : 4) << width;
    }
}

TEST(Voids, LieOnTheSurfaceAndAwayFromAllSamples)
{
    const OrientedSamples samples = shapes::sphere(3500, 1, 1);
    const PnRefinement refined = refine_before_steps(samples);
    ASSERT_GT(refined.void_points, 0);
    const NeighbourSearch search(samples.points);
    const double spacing = std::sqrt(4 * M_PI / 3500);
    for (const Point& p : refined.points)
    {
        EXPECT_NEAR(p.norm(), 1, 1e-4);
        EXPECT_GT((samples.points[std::size_t(search.nearest(p))] - p).norm(), 0.7 * spacing);
    }
}

} // namespace
