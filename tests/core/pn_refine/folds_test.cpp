#include "one_thread.h"

#include "filter_pn_refine/patch/hermite_surface.h"
#include "filter_pn_refine/refine.h"
#include "filter_pn_refine/samples/normal_noise.h"
#include "filter_pn_refine/samples/usable_samples.h"

#include "tests/shapes.h"

#include <recon/search/neighbours.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace
{

using namespace recon;

TEST(HermiteSurface, InterpolatesPositionsAndNormals)
{
    const OrientedSamples samples = shapes::ellipsoid(pn::HermiteSurface::most, {1, 2, 3}, 3);
    std::vector<int> all(samples.points.size());
    std::iota(all.begin(), all.end(), 0);
    const pn::HermiteSurface surface(samples, all.data(), int(all.size()), {0.2, 0.1, 0}, 1.7);
    for (std::size_t i = 0; i < all.size(); ++i)
    {
        Point p = samples.points[i];
        const Vector gradient = surface.project(p);
        EXPECT_LT((p - samples.points[i]).norm(), 1e-8);
        EXPECT_LT((gradient - samples.normals[i]).norm(), 1e-8);
    }
}

TEST(HermiteSurface, ProjectsOntoTheSphereThatWasSampled)
{
    const OrientedSamples samples = shapes::sphere(200, 1, 3);
    const NeighbourSearch search(samples.points);
    for (const Point& at : shapes::sphere(20, 1.05, 9).points)
    {
        int nearest[14];
        double squared[14];
        search.nearest(at, 14, nearest, squared);
        Point p = at;
        const Vector gradient = pn::HermiteSurface(samples, nearest, 14, at, 0.25).project(p);
        EXPECT_NEAR(p.norm(), 1, 1e-3);
        EXPECT_GT(gradient.normalized().dot(p.normalized()), 0.9999);
    }
}

/// Noise on both tangent axes of each normal: its standard deviation is the tangent of the angle.
OrientedSamples with_noisy_normals(OrientedSamples samples, double tangent)
{
    const Points moved = shapes::with_noise(samples.normals, tangent, 7);
    for (std::size_t i = 0; i < samples.normals.size(); ++i)
    {
        Vector& n = samples.normals[i];
        const Vector aside = moved[i] - n;
        n = (n + aside - aside.dot(n) * n).normalized();
    }
    return samples;
}

TEST(NormalNoise, IsEstimated)
{
    const OrientedSamples clean = shapes::torus(3000, 1, 0.4, 5);
    for (const double noise : {0.0, 0.1, 0.2})
    {
        pn::UsableSamples usable;
        const OrientedSamples samples = with_noisy_normals(clean, noise);
        pn::choose_usable_samples(samples, {}, UnitFrame(samples.points), 0.8, 1, {}, usable);
        EXPECT_NEAR(pn::estimate_normal_noise(usable), noise, 0.03);
    }
}

TEST(NormalNoise, IsSmoothedInNewPoints)
{
    const OrientedSamples samples = with_noisy_normals(shapes::sphere(1500, 1, 6), 0.35);
    double error[2];
    for (const bool fast : {false, true}) // which keeps to PN triangles
    {
        PnRefineOptions options = one_thread(1);
        options.fast = fast;
        const PnRefinement refined = refine_points(samples, options);
        error[fast] = 0;
        for (const Point& p : refined.points)
            error[fast] += std::pow(p.norm() - 1, 2) / double(refined.points.size());
    }
    EXPECT_LT(error[0], 0.4 * error[1]);
}

/// How much of the rim of a flat ellipsoid (half axes 1, 1, h) has a point nearer than `reach` whose normal is not that
/// of the flat sides.
double covered_rim(const OrientedSamples& cloud, double reach)
{
    const NeighbourSearch search(cloud.points);
    int covered = 0;
    constexpr int places = 720;
    std::vector<int> near;
    for (int k = 0; k < places; ++k)
    {
        const double a = 2 * M_PI * k / places;
        const Vector outward(std::cos(a), std::sin(a), 0);
        search.within(outward, reach, near);
        covered += std::any_of(near.begin(), near.end(),
                               [&](int j) { return cloud.normals[std::size_t(j)].dot(outward) > 0.5; });
    }
    return covered / double(places);
}

OrientedSamples join(OrientedSamples all, const PnRefinement& refined)
{
    all.points.insert(all.points.end(), refined.points.begin(), refined.points.end());
    all.normals.insert(all.normals.end(), refined.normals.begin(), refined.normals.end());
    return all;
}

TEST(Folds, RimOfAFlatEllipsoidIsClosed)
{
    // 0.08 between samples, and the rim bends within 0.04.
    const Vector half_axes(1, 1, 0.06);
    const OrientedSamples samples = shapes::ellipsoid(1000, half_axes, 2);
    const PnRefinement refined = refine_points(samples, one_thread(3));
    EXPECT_GT(refined.fold_points, 0);
    PnRefineOptions three_threads = one_thread(3);
    three_threads.threads = 3;
    EXPECT_EQ(refined.points, refine_points(samples, three_threads).points);
    EXPECT_GT(covered_rim(join(samples, refined), 0.06), 0.98);
    for (const Point& p : refined.points)
    {
        const Vector scaled = p.cwiseQuotient(half_axes);
        const double to_first_order = (scaled.norm() - 1) * scaled.norm() / scaled.cwiseQuotient(half_axes).norm();
        EXPECT_LT(std::abs(to_first_order), 0.06) << p.transpose();
    }
}

TEST(Folds, NothingIsPutAtTheRimOfAnOpenSheet)
{
    // Were walks to start there, some would end among samples again, across bays of these ragged rims.
    for (std::uint64_t seed = 1; seed <= 10; ++seed)
    {
        OrientedSamples square, hemisphere;
        const OrientedSamples ball = shapes::sphere(1000, 1, seed);
        for (std::size_t i = 0; i < ball.points.size(); ++i)
        {
            const Point& p = ball.points[i];
            square.points.emplace_back(p.z(), std::atan2(p.y(), p.x()), 0); // evenly spread as well
            square.normals.push_back(Vector::UnitZ());
            if (p.z() <= 0)
                continue;
            hemisphere.points.push_back(p);
            hemisphere.normals.push_back(ball.normals[i]);
        }
        EXPECT_EQ(refine_before_steps(square).fold_points, 0) << seed;
        EXPECT_EQ(refine_before_steps(hemisphere).fold_points, 0) << seed;
    }
}

TEST(Folds, TipsEndNearTheSamples)
{
    // A pointed cone whose tip has no samples. The smooth surface through them goes on by 0.92 spacings.
    constexpr double slope = 10 * M_PI / 180, spacing = 0.031;
    double above = 0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed)
    {
        OrientedSamples cone;
        double top = -1;
        for (const Point& p : shapes::sphere(600, 1, seed).points)
        {
            const double z = -std::sqrt(0.51 + 0.49 * p.z()), a = std::atan2(p.y(), p.x());
            cone.points.emplace_back(-z * std::tan(slope) * std::cos(a), -z * std::tan(slope) * std::sin(a), z);
            cone.normals.emplace_back(std::cos(a) * std::cos(slope), std::sin(a) * std::cos(slope), std::sin(slope));
            top = std::max(top, z);
        }
        const PnRefinement refined = refine_before_steps(cone);
        ASSERT_GT(refined.fold_points, 0);
        double highest = -1;
        for (const Point& p : refined.points)
            highest = std::max(highest, p.z());
        above += (highest - top) / spacing / 4;
    }
    EXPECT_GT(above, 0.2);
    EXPECT_LT(above, 0.75);
}

TEST(Folds, AreLeftOpenWhereNothingIsRefined)
{
    const OrientedSamples samples = shapes::ellipsoid(1000, {1, 1, 0.06}, 2);
    PnRefineHints hints;
    for (const Point& p : samples.points)
        hints.is_refined.push_back(p.x() > 0);
    const PnRefinement refined = refine_before_steps(samples, hints);
    EXPECT_GT(refined.fold_points, 0);
    for (const Point& p : refined.points)
        EXPECT_GT(p.x(), -0.25);
}

TEST(Folds, StayOpenWherePointsAreLimited)
{
    const OrientedSamples samples = shapes::ellipsoid(1000, {1, 1, 0.06}, 2);
    PnRefineOptions options = one_thread(1);
    options.max_points = int(samples.points.size() + refine_before_steps(samples).points.size());
    EXPECT_GT(refine_points(samples, options).fold_points, 0);
    options.max_points = int(samples.points.size());
    EXPECT_EQ(refine_points(samples, options).points.size(), 0u);
    EXPECT_EQ(refine_points(samples, one_thread(0)).points.size(), 0u);
}

TEST(Folds, TakeTheirAttributesFromSamplesAround)
{
    const OrientedSamples samples = shapes::ellipsoid(1000, {1, 1, 0.06}, 2);
    const PnRefinement refined = refine_before_steps(samples);
    ASSERT_GT(refined.fold_points, 0);
    std::vector<double> x;
    for (const Point& p : samples.points)
        x.push_back(p.x());
    const std::vector<double> made = interpolate(refined, x);
    for (std::size_t i = 0; i < made.size(); ++i)
        EXPECT_NEAR(made[i], refined.points[i].x(), 0.3);
}

TEST(Sheets, ThatFaceTheSameWayAreNotJoined)
{
    // Layers nearer to each other than a point's radius. Without the rule for slopes half of the new points lie
    // between.
    OrientedSamples layers;
    shapes::Random random(3);
    const auto uniform = [&] { return shapes::uniform(random); };
    for (int i = 0; i < 4000; ++i)
    {
        const Eigen::Vector2d place = shapes::draw_pair(uniform);
        layers.points.emplace_back(place.x(), place.y(), i % 2 ? 0.04 : 0);
        layers.normals.push_back(Vector::UnitZ());
    }
    const PnRefinement refined = refine_points(layers, one_thread(1));
    const auto between = std::count_if(refined.points.begin(), refined.points.end(),
                                       [](const Point& p) { return p.z() > 1e-6 && p.z() < 0.04 - 1e-6; });
    EXPECT_LT(double(between), 0.4 * double(refined.points.size())) << refined.points.size();
}

} // namespace
