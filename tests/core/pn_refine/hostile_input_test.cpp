#include "filter_pn_refine/refine.h"

#include "tests/shapes.h"

#include <recon/errors.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace
{

using namespace recon;

PnRefinement refine(const OrientedSamples& samples, int steps = 2)
{
    PnRefineOptions options;
    options.steps = steps;
    options.threads = 1;
    return refine_points(samples, options);
}

void expect_finite(const PnRefinement& refined)
{
    for (std::size_t i = 0; i < refined.points.size(); ++i)
    {
        EXPECT_TRUE(refined.points[i].allFinite());
        EXPECT_NEAR(refined.normals[i].norm(), 1, 1e-9);
        EXPECT_TRUE(std::isfinite(refined.radii[i]));
        EXPECT_GE(refined.radii[i], 0);
    }
}

TEST(HostileInput, NothingAndNonsenseAreRefused)
{
    EXPECT_THROW(refine({}), InvalidInput);
    OrientedSamples samples = shapes::sphere(100, 1, 1);
    samples.normals.pop_back();
    EXPECT_THROW(refine(samples), InvalidInput);
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    {
        samples = shapes::sphere(100, 1, 1);
        samples.points[7].y() = bad;
        EXPECT_THROW(refine(samples), InvalidInput);
    }
    samples = shapes::sphere(100, 1, 1);
    samples.normals.assign(100, Vector::Zero());
    EXPECT_THROW(refine(samples), InvalidInput);
}

TEST(HostileInput, OptionsOutOfRangeAreNamed)
{
    const OrientedSamples samples = shapes::sphere(100, 1, 1);
    const auto message = [&](PnRefineOptions options)
    {
        try
        {
            refine_points(samples, options);
        }
        catch (const InvalidInput& e)
        {
            return std::string(e.what());
        }
        return std::string("nothing thrown");
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    PnRefineOptions o;
    o.steps = -1;
    EXPECT_NE(message(o).find("steps"), std::string::npos);
    o = {};
    o.target_radius = nan;
    EXPECT_NE(message(o).find("target radius"), std::string::npos);
    o = {};
    o.initial_radius = -1;
    EXPECT_NE(message(o).find("initial radius"), std::string::npos);
    o = {};
    o.hole_radius = INFINITY;
    EXPECT_NE(message(o).find("hole radius"), std::string::npos);
    o = {};
    o.boundary_angle = 100;
    EXPECT_NE(message(o).find("boundary angle"), std::string::npos);
    o = {};
    o.crease_angle = 181;
    EXPECT_NE(message(o).find("crease angle"), std::string::npos);
    o = {};
    o.max_points = 0;
    EXPECT_NE(message(o).find("largest number"), std::string::npos);
    o = {};
    o.threads = -2;
    EXPECT_NE(message(o).find("threads"), std::string::npos);
}

TEST(HostileInput, FewOrDegeneratePointsGiveNothingOrLittle)
{
    for (int n : {1, 2, 3, 4, 5})
    {
        OrientedSamples samples = shapes::sphere(n, 1, 3);
        expect_finite(refine(samples, 3));
    }
    OrientedSamples equal;
    equal.points.assign(50, Point(1, 2, 3));
    equal.normals.assign(50, Vector::UnitZ());
    EXPECT_TRUE(refine(equal).points.empty());
    OrientedSamples line;
    for (int i = 0; i < 50; ++i)
    {
        line.points.emplace_back(i, 2 * i, 0);
        line.normals.push_back(Vector::UnitZ());
    }
    const PnRefinement refined = refine(line, 3);
    expect_finite(refined);
    for (const Point& p : refined.points)
        EXPECT_NEAR(p.y(), 2 * p.x(), 1e-9);
}

TEST(HostileInput, DuplicatesZeroNormalsAndIsolatedPointsAreLeftOutWithCounts)
{
    OrientedSamples samples = shapes::sphere(1000, 1, 4);
    for (int i = 0; i < 100; ++i)
    {
        samples.points.push_back(samples.points[std::size_t(i)]);
        samples.normals.push_back(samples.normals[std::size_t(i)]);
    }
    samples.normals[500].setZero();
    samples.normals[501].x() = std::numeric_limits<double>::quiet_NaN();
    samples.points.emplace_back(9, 9, 9);
    samples.normals.push_back(Vector::UnitX());
    const PnRefinement refined = refine(samples, 3);
    expect_finite(refined);
    EXPECT_EQ(refined.left_out, 103);
    EXPECT_EQ(refined.warnings.size(), 3u);
    EXPECT_EQ(refined.input_radii[500], 0);
    EXPECT_EQ(refined.input_radii[1100], 0);
    for (const Point& p : refined.points)
        EXPECT_LT(std::abs(p.norm() - 1), 0.01);
}

TEST(HostileInput, NoiseInPositionsAndNormalsIsNoRunaway)
{
    std::mt19937 random(5);
    std::normal_distribution<double> gauss;
    for (const double degrees : {0.0, 15.0, 30.0})
        for (const double noise : {0.0, 0.0035})
        {
            OrientedSamples samples = shapes::sphere(3500, 1, 6);
            for (std::size_t i = 0; i < samples.points.size(); ++i)
            {
                const Vector turn = degrees * M_PI / 180 * shapes::draw_vector([&] { return gauss(random); });
                samples.normals[i] = (samples.normals[i] + turn).normalized();
                samples.points[i] += noise * shapes::draw_vector([&] { return gauss(random); });
            }
            const PnRefinement refined = refine(samples, 3);
            expect_finite(refined);
            EXPECT_GT(refined.points.size(), 7000u) << degrees;
            EXPECT_LT(refined.points.size(), 80000u) << degrees;
            double worst = 0, sum = 0;
            for (const Point& p : refined.points)
            {
                worst = std::max(worst, std::abs(p.norm() - 1));
                sum += (p.norm() - 1) * (p.norm() - 1);
            }
            EXPECT_LT(worst, 0.02 + 0.005 * degrees) << degrees;
            EXPECT_LT(std::sqrt(sum / double(refined.points.size())), 0.006 + 0.0008 * degrees) << degrees;
            EXPECT_LT(refined.steps.back().largest_radius, 0.3);
        }
}

TEST(HostileInput, NormalsOfAnyLengthAndExtremeCoordinates)
{
    OrientedSamples samples = shapes::sphere(500, 1, 7);
    const PnRefinement plain = refine(samples);
    for (std::size_t i = 0; i < 500; ++i)
        samples.normals[i] *= i % 2 ? 1e-200 : 1e200;
    EXPECT_NEAR(double(refine(samples).points.size()), double(plain.points.size()), 0.02 * double(plain.points.size()));
    for (const double scale : {1e-30, 1e30})
    {
        OrientedSamples scaled = shapes::sphere(500, scale, 7);
        const PnRefinement refined = refine(scaled);
        EXPECT_EQ(refined.points.size(), plain.points.size());
        for (const Point& p : refined.points)
            EXPECT_NEAR(p.norm() / scale, 1, 0.01);
    }
}

TEST(HostileInput, RandomPointsWithRandomNormals)
{
    std::mt19937 random(8);
    std::normal_distribution<double> gauss;
    OrientedSamples samples;
    for (int i = 0; i < 1000; ++i)
    {
        samples.points.push_back(shapes::draw_vector([&] { return gauss(random); }));
        samples.normals.push_back(shapes::draw_vector([&] { return gauss(random); }));
    }
    const PnRefinement refined = refine(samples, 3);
    expect_finite(refined);
    EXPECT_LT(refined.points.size(), 60000u);
}

} // namespace
