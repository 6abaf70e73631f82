#include <recon/crust/crust.h>
#include <recon/labelling/labelled_balls.h>
#include <recon/mesh/mismatch.h>

#include <gtest/gtest.h>

#include <tests/shapes.h>

using namespace recon;

namespace
{

TriangleMesh sphere_crust()
{
    PhaseTimes times;
    return make_crust(label_polar_balls(shapes::sphere(3000, 0.5, 1).points, {}, {}, times), {});
}

TEST(MeasureMismatch, CountsThePointsAndTheAreaOfWhatOnlyOneOfThemHas)
{
    const TriangleMesh whole = sphere_crust();
    TriangleMesh half = whole;
    half.triangles.clear();
    for (const auto& t : whole.triangles)
        if (whole.vertices[t[0]].z() > 0)
            half.triangles.push_back(t);
    const Points points = shapes::sphere(3000, 0.5, 1).points;
    Points upper;
    for (const Point& p : points)
        if (p.z() > 0)
            upper.push_back(p);

    const Mismatch none = measure_mismatch(points, whole), missed = measure_mismatch(points, half),
                   bare = measure_mismatch(upper, whole);
    EXPECT_LT(none.sum(), 0.01);
    EXPECT_NEAR(missed.missed_points, 0.5, 0.08);
    EXPECT_LT(missed.bare_area, 0.01);
    EXPECT_NEAR(bare.bare_area, 0.5, 0.08);
    EXPECT_LT(bare.missed_points, 0.01);
    EXPECT_EQ(measure_missed_points(points, half), missed.missed_points);
    EXPECT_EQ(measure_bare_area(upper, whole), bare.bare_area);
    // The lower pole is 0.71 off the rim.
    EXPECT_EQ(measure_missed_points(points, half, 1, {}, 0.15), 0);
    EXPECT_NEAR(measure_missed_points(points, half, 1, {}, 0.05), 0.25, 0.08); // 0.25 and more off the rim
}

// Twice as far off counts four times, and points within their spacing not at all.
TEST(MeasureMismatch, WeighsMissedPointsByTheirDistance)
{
    const TriangleMesh mesh = sphere_crust();
    const auto measure = [&](double off)
    {
        Points points;
        for (const Point& p : shapes::sphere(3000, 0.5, 1).points)
            points.push_back(p * (1 + 2 * off));
        return measure_mismatch(points, mesh);
    };
    const Mismatch near = measure(0.005), far = measure(0.2), farther = measure(0.4);
    EXPECT_EQ(near.missed_by, 0);
    EXPECT_EQ(far.missed_points, 1);
    EXPECT_NEAR(farther.missed_by / far.missed_by, 2 * 1.4 / 1.8, 0.02); // the spacing grows with the sphere
    EXPECT_EQ(far.weighted_sum(), far.missed_by + far.bare_area);
}

// Points over a square in the plane z = 0.
TEST(MeasureNoiseMisfit, TellsTwoSheetsFromNoise)
{
    constexpr double sigma = 0.01;
    TriangleMesh square;
    square.vertices = {Point(0, 0, 0), Point(1, 0, 0), Point(1, 1, 0), Point(0, 1, 0)};
    square.triangles = {{0, 1, 2}, {0, 2, 3}};
    shapes::Random random(5);
    Points flat;
    for (int i = 0; i < 30'000; ++i) // more than are asked
    {
        const Eigen::Vector2d place = shapes::draw_pair([&] { return shapes::uniform(random); });
        flat.emplace_back(place.x(), place.y(), 0);
    }
    const Points noisy = shapes::with_noise(flat, sigma, 6);

    const NoiseMisfit by_noise = measure_noise_misfit(noisy, square, sigma);
    EXPECT_NEAR(by_noise.beyond_noise, 0.0027, 0.0015);
    EXPECT_LT(by_noise.two_sheets, 0.003);

    Points sheets = shapes::with_noise(flat, 0.5 * sigma, 7);
    for (std::size_t i = 0; i < sheets.size(); ++i)
        sheets[i].z() += (i % 2 == 0 ? 1.5 : -1.5) * sigma;
    const NoiseMisfit by_sheets = measure_noise_misfit(sheets, square, sigma);
    EXPECT_LT(by_sheets.beyond_noise, 0.005);
    EXPECT_GT(by_sheets.two_sheets, 0.95);
    // Nearer ones are mixed: all places together tell them from noise, their tails from noise of bounded reach.
    EXPECT_TRUE(by_noise.is_noise());
    EXPECT_NEAR(by_noise.evenness, 0.8, 0.005);
    constexpr double small = 0.3 * sigma;
    Points mixed = shapes::with_noise(flat, small, 8), bounded = flat;
    for (std::size_t i = 0; i < flat.size(); ++i)
    {
        mixed[i].z() += (i % 2 == 0 ? small : -small);
        bounded[i].z() += (2 * shapes::uniform(random) - 1) * small;
    }
    const NoiseMisfit by_mixed = measure_noise_misfit(mixed, square, 1.4 * small);
    EXPECT_LT(by_mixed.two_sheets, 0.01);
    EXPECT_NEAR(by_mixed.evenness, 0.825, 0.005);
    EXPECT_GT(by_mixed.tails, 0.03);
    const NoiseMisfit by_bounded = measure_noise_misfit(bounded, square, 0.6 * small);
    EXPECT_GT(by_bounded.evenness, by_mixed.evenness);
    EXPECT_LT(by_bounded.tails, 0.01);

    const NoiseMisfit by_three_threads = measure_noise_misfit(sheets, square, sigma, 3);
    EXPECT_EQ(by_three_threads.beyond_noise, by_sheets.beyond_noise);
    EXPECT_EQ(by_three_threads.two_sheets, by_sheets.two_sheets);
    EXPECT_EQ(by_three_threads.evenness, by_sheets.evenness);

    EXPECT_NEAR(measure_noise_misfit(noisy, square, sigma / 3).beyond_noise, 0.32, 0.02); // beyond one sigma
    EXPECT_EQ(measure_noise_misfit({}, square, sigma).beyond_noise, 0);
    EXPECT_EQ(measure_noise_misfit(noisy, {}, sigma).two_sheets, 0);
}

// A cup, an open scan with Gaussian noise, two with noise of bounded reach; few points of a cup.
TEST(MeasureNoiseMisfit, TellsMixedSheetsFromNoiseOfBoundedReach)
{
    const auto is_noise = [](double evenness, double tails, int points)
    {
        NoiseMisfit misfit;
        misfit.evenness = evenness;
        misfit.tails = tails;
        misfit.points = points;
        return misfit.is_noise();
    };
    EXPECT_FALSE(is_noise(0.8226, 0.0455, 20'000));
    EXPECT_TRUE(is_noise(0.7996, 0.0487, 20'000));
    EXPECT_TRUE(is_noise(0.8345, 0.0233, 20'000));
    EXPECT_TRUE(is_noise(0.8258, 0.0352, 20'000));
    EXPECT_TRUE(is_noise(0.8226, 0.0455, 400));
}

TEST(MeasureMismatch, IsToldOnlyWherePartsAreLost)
{
    EXPECT_EQ(describe_missed(0), "");
    EXPECT_EQ(describe_missed(missed_without_a_word), "");
    EXPECT_EQ(describe_missed(0.1022).substr(0, 6), "10.2 %");
}

TEST(MeasureMismatch, StandsHostileInput)
{
    const Points points = shapes::sphere(100, 0.5, 1).points;
    EXPECT_EQ(measure_mismatch(points, {}).missed_points, 1);
    EXPECT_EQ(measure_mismatch({}, sphere_crust()).sum(), 0);
    EXPECT_EQ(measure_missed_points({}, sphere_crust()) + measure_bare_area({}, sphere_crust()), 0);
    TriangleMesh degenerate;
    degenerate.vertices = {Point(0, 0, 0), Point(1, 0, 0), Point(2, 0, 0)};
    degenerate.triangles = {{0, 1, 2}, {0, 0, 1}};
    const double most = measure_mismatch(points, degenerate).sum(); // the segment passes through the sphere
    EXPECT_GT(most, 0.95);
    EXPECT_LT(most, 1);
    EXPECT_LE(measure_mismatch({Point(0, 0, 0)}, degenerate).sum(), 1);
}

TEST(MeasureMismatch, IsTheSameForAnyNumberOfThreads)
{
    const Points points = shapes::sphere(30'000, 0.5, 2).points; // more than are asked
    const TriangleMesh mesh = sphere_crust();
    const Mismatch one = measure_mismatch(points, mesh, 1), three = measure_mismatch(points, mesh, 3);
    EXPECT_EQ(one.missed_points, three.missed_points);
    EXPECT_EQ(one.missed_by, three.missed_by);
    EXPECT_EQ(one.bare_area, three.bare_area);
}

} // namespace
