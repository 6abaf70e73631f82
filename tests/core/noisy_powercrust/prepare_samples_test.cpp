#include "filter_noisy_powercrust/labels/prepare_samples.h"

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace recon;

namespace
{

PreparedSamples prepare(const Points& points, const SamplePreparationOptions& options = {})
{
    PhaseTimes times;
    LatestSurface latest;
    return prepare_samples(points, options, latest, times);
}

} // namespace

TEST(PrepareSamples, OneNoisySampleASpotIsNoise)
{
    constexpr double thickness = 12; // spacings
    const Points plate = shapes::thin_plate(40, thickness, 5);
    EXPECT_FALSE(prepare(plate).denoised);
    for (const double noise : {0.1, 0.25})
    {
        const PreparedSamples cloud = prepare(shapes::with_noise(plate, noise, 4));
        EXPECT_GT(cloud.cleanness, 0.7); // long, thin cells
        EXPECT_FALSE(cloud.is_doubtful);
        EXPECT_TRUE(cloud.denoised);
        double sum = 0;
        for (const Point& p : cloud.samples)
            sum += std::pow(std::abs(p.z() * cloud.frame.scale()) - thickness / 2, 2);
        EXPECT_LT(std::sqrt(sum / double(cloud.samples.size())), 0.7 * noise) << noise;
    }
}

TEST(PrepareSamples, ACloudThatIsNoisyInPartsIsDenoised)
{
    const Points torus = shapes::torus(20'000, 1, 0.3, 3).points;
    const double noise = 0.5 * std::sqrt(4 * EIGEN_PI * EIGEN_PI * 0.3 / double(torus.size()));
    EXPECT_FALSE(prepare(torus).denoised);
    const PreparedSamples cloud = prepare(shapes::with_noise_beyond(0, torus, noise, 5));
    EXPECT_TRUE(cloud.denoised);
    double squares[2] = {}, count[2] = {};
    for (const Point& p : cloud.samples)
    {
        const Point at = cloud.frame.from_unit(p);
        squares[at.x() > 0] += std::pow(shapes::distance_to_torus(at, 1, 0.3), 2);
        ++count[at.x() > 0];
    }
    EXPECT_LT(std::sqrt(squares[1] / count[1]), 0.4 * noise);
    EXPECT_LT(std::sqrt(squares[0] / count[0]), 0.1 * noise) << "the clean half";
}

// As of two scanners of different quality. Crusts of the points as they are passed by all noisy ones.
TEST(PrepareSamples, ACloudOfWhichSomePointsAreNoisyIsDenoised)
{
    const Points torus = shapes::torus(20'000, 1, 0.3, 3).points;
    const double noise = 0.7 * std::sqrt(4 * EIGEN_PI * EIGEN_PI * 0.3 / double(torus.size()));
    for (const double share : {0.1, 0.3})
    {
        const PreparedSamples cloud = prepare(shapes::with_noisy_share(share, torus, noise, 5));
        EXPECT_TRUE(cloud.denoised) << share;
        Points left = cloud.samples;
        cloud.frame.from_unit_in_place(left);
        const auto distance = [](const Point& p) { return shapes::distance_to_torus(p, 1, 0.3); };
        EXPECT_LT(shapes::rms(left, distance), 0.4 * std::sqrt(share) * noise) << share;
    }
}

TEST(PrepareSamples, NoiseThatIsGivenIsRemovedWhetherItShowsOrNot)
{
    const Points torus = shapes::torus(4'000, 1, 0.3, 3).points;
    const double spacing = std::sqrt(4 * EIGEN_PI * EIGEN_PI * 0.3 / double(torus.size()));
    for (const double noise : {0.0, 0.1 * spacing, 0.5 * spacing})
    {
        SamplePreparationOptions options;
        options.noise = noise;
        EXPECT_EQ(prepare(torus, options).denoised, noise > 0.2 * spacing) << noise;
    }
}

TEST(PrepareSamples, OutliersOfACleanCloudAreLeftOut)
{
    const Points torus = shapes::torus(8000, 1, 0.3, 3).points;
    EXPECT_EQ(prepare(torus).isolated, 0);
    Points points = torus;
    for (const Point& p : shapes::scattered(200, {4, 4, 4}, 7))
        if (points.size() < 8100 && shapes::distance_to_torus(p, 1, 0.3) > 0.2)
            points.push_back(p);
    const PreparedSamples cloud = prepare(points), alone = prepare(torus);
    EXPECT_FALSE(cloud.denoised);
    EXPECT_EQ(cloud.isolated, 100);
    EXPECT_EQ(cloud.outliers, 100);
    EXPECT_EQ(cloud.order, alone.order) << "as if they had never been";
    EXPECT_EQ(cloud.samples, alone.samples);
    PhaseTimes times;
    LatestSurface latest;
    EXPECT_EQ(prepare_samples(points, {Denoise::off}, latest, times).isolated, 0) << "as the paper has it";
}

TEST(PrepareSamples, AttemptsAtACloudShareItsSurface)
{
    const Points torus = shapes::torus(2000, 1, 0.3, 3).points, other = shapes::torus(2000, 1, 0.3, 4).points;
    LatestSurface latest;
    PhaseTimes times;
    const auto surface_of = [&](const Points& points, double noise) {
        return *prepare_samples(points, {Denoise::on, noise}, latest, times).surface;
    };
    const AmlsSurface first = surface_of(torus, 0);
    EXPECT_EQ(&surface_of(torus, 0).data(), &first.data());
    EXPECT_NE(&surface_of(torus, 0.01).data(), &first.data());
    EXPECT_NE(&surface_of(other, 0).data(), &first.data());
}

TEST(PrepareSamples, LoneVerticesOfACoarseMeshAreNoOutliers)
{
    // Two finely divided rims, six vertices between.
    Points barrel;
    constexpr int steps = 100;
    for (int i = 0; i < steps; ++i)
        for (const double z : {-3.0, 3.0})
            barrel.emplace_back(std::cos(2 * EIGEN_PI * i / steps), std::sin(2 * EIGEN_PI * i / steps), z);
    for (int i = 0; i < 6; ++i)
        barrel.emplace_back(1.4 * std::cos(i), 1.4 * std::sin(i), 0.9 * std::sin(3 * i));
    EXPECT_EQ(prepare(barrel).isolated, 0);
}

TEST(PrepareSamples, ThinWallsAreNoNoiseThoughTheEstimateSaysSo)
{
    const PreparedSamples cloud = prepare(shapes::thin_plate(30, 1.5, 5));
    EXPECT_FALSE(cloud.is_doubtful);
    EXPECT_FALSE(cloud.denoised);
}
