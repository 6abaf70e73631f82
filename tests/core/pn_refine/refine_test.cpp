#include "one_thread.h"

#include "filter_pn_refine/refine.h"

#include "tests/checks.h"
#include "tests/shapes.h"

#include <recon/errors.h>
#include <recon/search/neighbours.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <numeric>
#include <set>
#include <string>
#include <utility>

namespace
{

using namespace recon;

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b)
{
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

Points all_points(const OrientedSamples& input, const PnRefinement& refined)
{
    Points all = input.points;
    all.insert(all.end(), refined.points.begin(), refined.points.end());
    return all;
}

/// Largest distance from a test point on the surface to the cloud.
double largest_gap(const Points& surface, const Points& cloud)
{
    const NeighbourSearch search(cloud);
    double largest = 0;
    for (const Point& p : surface)
        largest = std::max(largest, (cloud[std::size_t(search.nearest(p))] - p).norm());
    return largest;
}

double closest_pair(const Points& appended, const Points& all)
{
    const NeighbourSearch search(all);
    double least = 1e300;
    for (const Point& p : appended)
    {
        int indices[2];
        double squared[2];
        search.nearest(p, 2, indices, squared);
        least = std::min(least, std::sqrt(squared[1]));
    }
    return least;
}

TEST(RefinePoints, SphereBecomesDenseExactAndEven)
{
    const OrientedSamples samples = shapes::sphere(3500, 1, 1);
    const Points surface = shapes::sphere(200000, 1, 99).points;
    const double diagonal = 2 * std::sqrt(3.0);
    for (int steps = 1; steps <= 6; ++steps)
    {
        const PnRefinement refined = refine_points(samples, one_thread(steps));
        const Points all = all_points(samples, refined);
        const double spacing = std::sqrt(12.566 / double(all.size()));
        // At the last steps the test points themselves are too few to find the largest gap: a lower bound then.
        EXPECT_LT(largest_gap(surface, all), 1.8 * spacing) << steps;
        EXPECT_GT(closest_pair(refined.points, all), 0.1 * spacing) << steps;
        EXPECT_EQ(refined.steps.size(), std::size_t(steps));
        EXPECT_EQ(refined.steps.back().points, int(all.size()));
        EXPECT_GT(double(all.size()), 3500 * std::pow(1.75, steps));
    }
    const PnRefinement refined = refine_points(samples, one_thread(6));
    EXPECT_LT(shapes::rms(refined.points, [](const Point& p) { return shapes::distance_to_sphere(p, 1); }) / diagonal,
              1e-6);
    double sum = 0;
    for (std::size_t i = 0; i < refined.points.size(); ++i)
    {
        EXPECT_NEAR(refined.normals[i].norm(), 1, 1e-12);
        const double angle = std::acos(std::min(1.0, refined.normals[i].dot(refined.points[i].normalized())));
        sum += angle * angle;
    }
    EXPECT_LT(std::sqrt(sum / double(refined.points.size())) * 180 / M_PI, 0.01);
}

TEST(RefinePoints, SamplesAroundTellMoreThanThreeCorners)
{
    double error[2] = {0, 0};
    for (std::uint64_t seed = 2; seed <= 4; ++seed)
    {
        const Vector half_axes(1, 0.5, 0.3);
        const OrientedSamples samples = shapes::ellipsoid(1000, half_axes, seed);
        for (const bool fast : {false, true})
        {
            PnRefineOptions options = one_thread(2);
            options.fast = fast;
            error[fast] +=
                shapes::rms(refine_points(samples, options).points,
                            [&](const Point& p)
                            {
                                const Vector scaled = p.cwiseQuotient(half_axes);
                                return (scaled.norm() - 1) * scaled.norm() / scaled.cwiseQuotient(half_axes).norm();
                            });
        }
    }
    EXPECT_LT(error[0], 0.6 * error[1]);
    EXPECT_LT(error[0] / 3, 2e-4);
}

TEST(RefinePoints, EmptyPlacesDoNotOutliveTheSteps)
{
    // Where angles alone decided, a hole between few points was left to itself: 2.7 spacings on one of these spheres.
    const Points surface = shapes::sphere(100000, 1, 99).points;
    for (int seed = 1; seed <= 5; ++seed)
    {
        const OrientedSamples samples = shapes::sphere(3500, 1, std::uint64_t(seed));
        const Points all = all_points(samples, refine_points(samples, one_thread(5)));
        EXPECT_LT(largest_gap(surface, all), 1.8 * std::sqrt(12.566 / double(all.size()))) << seed;
    }
}

TEST(RefinePoints, AHemisphereHasNoEmptyPlaceInsideAtAnyStep)
{
    // Angles at the rim of this one's largest hole lie just below 90 degrees: 2.1 spacings at step 1, 2.9 at step 5. At
    // step 6 2.6 where near neighbours hid those across holes.
    const auto upper_half = [](const OrientedSamples& sphere, double least)
    {
        OrientedSamples half;
        for (std::size_t i = 0; i < sphere.points.size(); ++i)
            if (sphere.points[i].z() >= least)
            {
                half.points.push_back(sphere.points[i]);
                half.normals.push_back(sphere.normals[i]);
            }
        return half;
    };
    OrientedSamples samples = upper_half(shapes::sphere(3500, 1, 2), 0);
    for (int i = 0; i < 105; ++i)
    {
        const double a = 2 * M_PI * i / 105;
        samples.points.emplace_back(std::cos(a), std::sin(a), 0);
        samples.normals.push_back(samples.points.back());
    }
    const Points surface = upper_half(shapes::sphere(200000, 1, 99), 0).points;
    for (const int steps : {1, 2, 4, 5, 6})
    {
        const PnRefinement refined = refine_points(samples, one_thread(steps));
        const Points all = all_points(samples, refined);
        EXPECT_LT(largest_gap(surface, all), 1.8 * std::sqrt(6.283 / double(all.size()))) << steps;
        for (const Point& p : refined.points)
            EXPECT_GT(p.z(), -0.001); // nothing spills over the rim
    }
}

TEST(RefinePoints, ErrorFallsWithTheNumberOfSamples)
{
    const auto error = [](int n)
    {
        const PnRefinement refined = refine_points(shapes::torus(n, 1, 0.4, 2), one_thread(2));
        return shapes::rms(refined.points, [](const Point& p) { return shapes::distance_to_torus(p, 1, 0.4); });
    };
    const double coarse = error(1000), fine = error(8000);
    EXPECT_LT(coarse, 0.005);
    EXPECT_LT(fine, coarse / 8);
}

TEST(RefinePoints, EveryNeighbourhoodReproducesThePlane)
{
    OrientedSamples plane = shapes::sphere(1500, 1, 8);
    for (std::size_t i = 0; i < plane.points.size(); ++i)
    {
        plane.points[i].z() = 0;
        plane.normals[i] = Vector::UnitZ();
    }
    for (const PnNeighbourhood n : {PnNeighbourhood::automatic, PnNeighbourhood::fuzzy, PnNeighbourhood::accurate})
        for (const bool fast : {false, true})
        {
            PnRefineOptions options = one_thread(3);
            options.neighbourhood = n;
            options.fast = fast;
            const PnRefinement refined = refine_points(plane, options);
            EXPECT_GT(refined.points.size(), 5000u);
            for (std::size_t i = 0; i < refined.points.size(); ++i)
            {
                EXPECT_NEAR(refined.points[i].z(), 0, 1e-15);
                EXPECT_NEAR(refined.normals[i].z(), 1, 1e-12);
                EXPECT_LT(refined.points[i].norm(), 1.0001); // nothing spills over the rim
            }
        }
}

TEST(RefinePoints, AlignedGridHasNoHoles)
{
    OrientedSamples grid;
    Points surface;
    for (int x = 0; x < 30; ++x)
        for (int y = 0; y < 30; ++y)
        {
            grid.points.emplace_back(x, y, 0);
            grid.normals.push_back(Vector::UnitZ());
        }
    for (double x = 0; x <= 29; x += 0.11)
        for (double y = 0; y <= 29; y += 0.11)
            surface.emplace_back(x, y, 0);
    const PnRefinement refined = refine_points(grid, one_thread(3));
    const Points all = all_points(grid, refined);
    EXPECT_LT(largest_gap(surface, all), 1.8 * 29 / std::sqrt(double(all.size())));
}

TEST(RefinePoints, SameBitsForEveryNumberOfThreads)
{
    const OrientedSamples samples = shapes::torus(4000, 1, 0.4, 3);
    PnRefineOptions options = one_thread(4);
    const PnRefinement one = refine_points(samples, options);
    EXPECT_GT(one.points.size(), 50000u);
    for (int threads : {1, 2, 3})
    {
        options.threads = threads;
        const PnRefinement other = refine_points(samples, options);
        EXPECT_TRUE(same_bits(one.points, other.points)) << threads;
        EXPECT_TRUE(same_bits(one.normals, other.normals)) << threads;
        EXPECT_TRUE(same_bits(one.radii, other.radii)) << threads;
        EXPECT_TRUE(same_bits(one.parents, other.parents)) << threads;
        EXPECT_TRUE(same_bits(one.input_radii, other.input_radii)) << threads;
    }
}

TEST(RefinePoints, TheOrderOfTheInputDoesNotMatter)
{
    const OrientedSamples samples = shapes::torus(2000, 1, 0.4, 8);
    OrientedSamples reversed = samples;
    std::reverse(reversed.points.begin(), reversed.points.end());
    std::reverse(reversed.normals.begin(), reversed.normals.end());
    const PnRefinement one = refine_points(samples, one_thread(3)), other = refine_points(reversed, one_thread(3));
    EXPECT_TRUE(same_bits(one.points, other.points));
    EXPECT_TRUE(same_bits(one.normals, other.normals));
    std::vector<double> radii = one.input_radii;
    std::reverse(radii.begin(), radii.end());
    EXPECT_TRUE(same_bits(radii, other.input_radii));
}

TEST(RefinePoints, NorDoesItWhereCoordinatesAreEqual)
{
    OrientedSamples grid;
    for (int x = 0; x < 60; ++x)
        for (int y = 0; y < 60; ++y)
        {
            grid.points.emplace_back(x, y, 1.2 * std::sin(0.3 * x) * std::cos(0.25 * y));
            const double along_x = 0.36 * std::cos(0.3 * x) * std::cos(0.25 * y),
                         along_y = -0.3 * std::sin(0.3 * x) * std::sin(0.25 * y);
            grid.normals.push_back(Vector(-along_x, -along_y, 1).normalized());
        }
    std::vector<std::size_t> order(grid.points.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    shapes::Random random(3);
    for (std::size_t i = order.size(); i > 1; --i)
        std::swap(order[i - 1], order[std::size_t(shapes::uniform(random) * double(i))]);
    OrientedSamples shuffled;
    for (const std::size_t i : order)
    {
        shuffled.points.push_back(grid.points[i]);
        shuffled.normals.push_back(grid.normals[i]);
    }
    const PnRefinement one = refine_points(grid, one_thread(3)), other = refine_points(shuffled, one_thread(3));
    EXPECT_TRUE(same_bits(one.points, other.points));
    EXPECT_TRUE(same_bits(one.normals, other.normals));
}

TEST(RefinePoints, FarFromTheOriginAndAtExtremeScalesTheResultIsTheSame)
{
    const OrientedSamples samples = shapes::sphere(800, 1, 5);
    const PnRefinement plain = refine_points(samples, one_thread(2));
    for (const double scale : {0x1p-90, 0x1p90})
    {
        OrientedSamples scaled = samples;
        for (Point& p : scaled.points)
            p *= scale;
        const PnRefinement other = refine_points(scaled, one_thread(2));
        ASSERT_EQ(other.points.size(), plain.points.size());
        double worst = 0;
        for (std::size_t i = 0; i < plain.points.size(); ++i)
            worst = std::max(worst, (other.points[i] / scale - plain.points[i]).norm());
        EXPECT_LT(worst, 1e-12);
    }
    OrientedSamples moved = samples;
    const Vector offset(0x1p19, 0x1p22, 128);
    for (Point& p : moved.points)
        p += offset;
    const PnRefinement other = refine_points(moved, one_thread(2));
    EXPECT_NEAR(double(other.points.size()), double(plain.points.size()), 0.02 * double(plain.points.size()));
    EXPECT_LT(shapes::rms(other.points, [&](const Point& p) { return shapes::distance_to_sphere(p - offset, 1); }),
              1e-3);
}

TEST(RefinePoints, ParentsAreEarlierAndNear)
{
    const OrientedSamples samples = shapes::sphere(500, 1, 6);
    const PnRefinement refined = refine_points(samples, one_thread(3));
    const Points all = all_points(samples, refined);
    ASSERT_EQ(refined.parents.size(), refined.points.size());
    ASSERT_EQ(refined.radii.size(), refined.points.size());
    ASSERT_EQ(refined.input_radii.size(), samples.points.size());
    for (std::size_t i = 0; i < refined.points.size(); ++i)
        for (int parent : refined.parents[i])
        {
            EXPECT_GE(parent, 0);
            EXPECT_LT(parent, int(500 + i));
            EXPECT_LT((all[std::size_t(parent)] - refined.points[i]).norm(), 0.6);
        }
    // A linear function of the position is interpolated to the curvature's order.
    std::vector<double> heights;
    for (const Point& p : samples.points)
        heights.push_back(p.z());
    const std::vector<double> made = interpolate(refined, heights);
    for (std::size_t i = 0; i < made.size(); ++i)
        EXPECT_NEAR(made[i], refined.points[i].z(), 0.08);
}

TEST(RefinePoints, StopsLocallyAtTheTargetRadius)
{
    const OrientedSamples samples = shapes::sphere(1000, 1, 7);
    PnRefineOptions options = one_thread(12);
    options.target_radius = 0.08;
    const PnRefinement refined = refine_points(samples, options);
    EXPECT_LT(refined.points.size(), 60000u);
    EXPECT_GT(refined.points.size(), 3000u);
    const auto small = std::count_if(refined.radii.begin(), refined.radii.end(), [](double r) { return r <= 0.08; });
    EXPECT_GT(double(small), 0.98 * double(refined.radii.size()));
}

TEST(RefinePoints, OnlyMarkedPointsAreRefined)
{
    const OrientedSamples samples = shapes::sphere(1000, 1, 9);
    PnRefineHints hints;
    for (const Point& p : samples.points)
        hints.is_refined.push_back(p.z() > 0.2);
    const PnRefinement refined = refine_points(samples, one_thread(2), hints);
    EXPECT_GT(refined.points.size(), 400u);
    for (const Point& p : refined.points)
        EXPECT_GT(p.z(), -0.1);
}

TEST(RefinePoints, MarkedIsolatedPointsTakeNoPart)
{
    OrientedSamples samples = shapes::sphere(1000, 1, 9);
    for (const Point& p : {Point(1.2, 0, 0), Point(1.2, 0.04, 0), Point(0, 1.15, 0)})
    {
        samples.points.push_back(p);
        samples.normals.push_back(Vector::UnitZ());
    }
    PnRefineHints hints;
    hints.is_isolated.assign(1000, 0);
    EXPECT_THROW(refine_points(samples, one_thread(2), hints), InvalidInput);
    hints.is_isolated.resize(1003, 1);
    const PnRefinement refined = refine_points(samples, one_thread(2), hints);
    EXPECT_EQ(refined.left_out, 3);
    EXPECT_GT(refined.points.size(), 2800u);
    for (const Point& p : refined.points)
        EXPECT_LT(shapes::distance_to_sphere(p, 1), 1e-3);
}

TEST(RefinePoints, NoStepBeyondTheLargestNumberOfPoints)
{
    const OrientedSamples samples = shapes::sphere(1000, 1, 10);
    PnRefineOptions options = one_thread(6);
    options.max_points = 6000;
    const PnRefinement refined = refine_points(samples, options);
    EXPECT_LE(refined.points.size() + 1000, 6000u);
    EXPECT_GT(refined.points.size(), 0u);
    EXPECT_LT(refined.steps.size(), 6u);
    ASSERT_EQ(refined.warnings.size(), 1u);
    EXPECT_NE(refined.warnings[0].find("6000"), std::string::npos);
}

TEST(RefinePoints, CreasesCountToTheLargestNumberOfPoints)
{
    const OrientedSamples cube = shapes::box(3000, Vector(2, 2, 2), 5);
    PnRefineOptions options = one_thread(1);
    options.max_points = 3000;
    EXPECT_EQ(refine_points(cube, options).points.size(), 0u);
    options.max_points = 3000 + refine_points(cube, one_thread(1)).crease_points;
    const PnRefinement refined = refine_points(cube, options);
    EXPECT_GT(refined.crease_points, 0);
    EXPECT_EQ(3000 + int(refined.points.size()), options.max_points);
}

TEST(RefinePoints, GivenRadiiAreUsedWithinReason)
{
    const OrientedSamples samples = shapes::sphere(1000, 1, 11);
    const PnRefinement found = refine_points(samples, one_thread(2));
    PnRefineHints hints;
    hints.radii.assign(1000, 1e-6); // made for drawing
    const PnRefinement tiny = refine_points(samples, one_thread(2), hints);
    EXPECT_GT(tiny.points.size(), found.points.size() / 2);
    hints.radii.assign(1000, 0.0); // none
    EXPECT_EQ(refine_points(samples, one_thread(2), hints).points.size(), found.points.size());
    PnRefineOptions options = one_thread(2);
    options.initial_radius = 0.25;
    const PnRefinement chosen = refine_points(samples, options);
    EXPECT_LT(shapes::rms(chosen.points, [](const Point& p) { return shapes::distance_to_sphere(p, 1); }), 1e-3);
    EXPECT_GT(chosen.points.size(), 500u);
    // Beyond the cloud no point has all others around it: that would take the square of the time.
    options.initial_radius = 2;
    const PnRefinement wild = refine_points(samples, options);
    options.initial_radius = 1e9;
    EXPECT_TRUE(same_bits(wild.points, refine_points(samples, options).points));
    EXPECT_TRUE(checks::says(wild.warnings, "initial radius is too large"));
    EXPECT_FALSE(checks::says(chosen.warnings, "initial radius"));
    EXPECT_LT(wild.steps[0].largest_radius, 1.8);
}

TEST(RefinePoints, ProgressRisesToTheEndAndCancels)
{
    const OrientedSamples samples = shapes::sphere(2000, 1, 12);
    double last = 0;
    int calls = 0;
    const PnRefinement refined = refine_points(samples, one_thread(3), {},
                                               Progress(
                                                   [&](double fraction, const std::string&)
                                                   {
                                                       EXPECT_GE(fraction, last);
                                                       last = fraction;
                                                       ++calls;
                                                       return true;
                                                   }));
    EXPECT_GT(calls, 20);
    EXPECT_GT(last, 0.9);
    for (const int stop : {1, calls / 3, calls - 2})
    {
        int count = 0;
        EXPECT_THROW(refine_points(samples, one_thread(3), {},
                                   Progress([&](double, const std::string&) { return ++count < stop; })),
                     Cancelled)
            << stop;
    }
}

TEST(RefinePoints, EveryPreparationTellsThatItGoesOn)
{
    std::set<std::string> phases;
    PnRefineOptions options = one_thread(1);
    options.hole_radius = 0.5;
    OrientedSamples open; // above
    const OrientedSamples cube = shapes::box(3000, Vector(2, 2, 2), 5);
    for (std::size_t i = 0; i < cube.points.size(); ++i)
        if (cube.points[i].z() < 1 || cube.points[i].head<2>().norm() > 0.4)
        {
            open.points.push_back(cube.points[i]);
            open.normals.push_back(cube.normals[i]);
        }
    refine_points(open, options, {},
                  Progress(
                      [&](double, const std::string& phase)
                      {
                          phases.insert(phase);
                          return true;
                      }));
    for (const char* phase : {"choosing points", "normals", "creases", "radii", "mouths", "holes", "voids", "folds"})
        EXPECT_EQ(phases.count(phase), 1u) << phase;
}

TEST(RefinePoints, WarnsOfNormalsThatContradictThePoints)
{
    const auto is_warned = [](const OrientedSamples& samples)
    { return checks::says(refine_points(samples, one_thread(0)).warnings, "contradict the points"); };
    OrientedSamples box = shapes::box(3000, Vector(2, 2, 2), 5);
    EXPECT_FALSE(is_warned(box));
    EXPECT_FALSE(is_warned(shapes::torus(500, 1, 0.3, 1)));
    EXPECT_FALSE(is_warned(shapes::sphere(60, 1, 1)));
    for (std::size_t i = 0; i < box.points.size(); ++i)
        box.normals[i] = box.points[i].normalized(); // those of the corners, interpolated
    EXPECT_TRUE(is_warned(box));
}

} // namespace
