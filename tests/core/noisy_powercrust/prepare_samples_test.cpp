#include "filter_noisy_powercrust/prepare_samples.h"

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace recon;

namespace
{

PreparedSamples prepare(const Points& points)
{
    PhaseTimes times;
    return prepare_samples(points, {}, times);
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

TEST(PrepareSamples, ThinWallsAreNoNoiseThoughTheEstimateSaysSo)
{
    const PreparedSamples cloud = prepare(shapes::thin_plate(30, 1.5, 5));
    EXPECT_FALSE(cloud.is_doubtful);
    EXPECT_FALSE(cloud.denoised);
}
