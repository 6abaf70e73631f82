#include <recon/crust/weaving.h>

#include <recon/mesh/crust_mesh.h>

#include <gtest/gtest.h>

using namespace recon;

namespace
{

NoiseMisfit misfit(double beyond_noise, double evenness)
{
    NoiseMisfit result;
    result.beyond_noise = beyond_noise;
    result.evenness = evenness;
    return result;
}

/// Of sheets of many scans; of points beyond the noise; of two sheets everywhere as far apart.
const NoiseMisfit scattered = misfit(0, 0.75), beyond = misfit(0.003, 0.75), even = misfit(0, 0.95);

} // namespace

TEST(MayWeave, IsAskedWhereVotesObjectAndNoiseWasTold)
{
    EXPECT_TRUE(may_weave(0.009, 0.15));
    EXPECT_FALSE(may_weave(0.0078, 0.15)); // thin parts
    EXPECT_FALSE(may_weave(0.009, 0.03));
}

TEST(LiesBetweenSheets, TheVolumeStaysAndHalfTheVotesAgain)
{
    const Woven first{0.04, 1.01, 6, 0.03};
    EXPECT_TRUE(lies_between_sheets(first, {0.01, 1, 0, 0.03}, scattered));
    EXPECT_FALSE(lies_between_sheets(first, {0.025, 1, 0, 0.03}, scattered));
    EXPECT_FALSE(lies_between_sheets(first, {0.01, 1, 7, 0}, scattered));
    EXPECT_FALSE(lies_between_sheets(first, {0.01, 1, 0, 0}, beyond)) << "limbs are lost";
    EXPECT_FALSE(lies_between_sheets(first, {0.01, 0.9, 0, 0}, scattered)) << "walls are lost";
    EXPECT_FALSE(lies_between_sheets(first, {0.01, 1.1, 0, 0.03}, scattered)) << "a hollow is filled";
    EXPECT_FALSE(lies_between_sheets(first, {0.01, 1, 0, 0.03}, even)) << "a pipe was filled before";
    EXPECT_TRUE(lies_between_sheets(first, {0.01, 1, 0, 0}, even));
}

// As of views a hundredth of the diagonal out of register.
TEST(LiesBetweenSheets, LaceEnclosesLessThanItShould)
{
    const Woven lace{0.04, 0.5, 15, 0.06};
    EXPECT_TRUE(lies_between_sheets(lace, {0.025, 1, 0, 0}, scattered));
    EXPECT_FALSE(lies_between_sheets(lace, {0.035, 1, 0, 0}, scattered));
    EXPECT_FALSE(lies_between_sheets(lace, {0.001, 1, 0, 0.026}, scattered)) << "a cup is filled";
    EXPECT_FALSE(lies_between_sheets({0.04, 0.5, 0, 0.06}, {0.001, 1, 0, 0}, scattered)) << "a hollow is filled";
    EXPECT_FALSE(lies_between_sheets(lace, {0.001, 1, 0, 0}, even)) << "a shell is filled";
    EXPECT_FALSE(lies_between_sheets(lace, {0.001, 0.25, 0, 0}, scattered));
}

// As of a real sweep, single_scan, and of a simulated one without noise.
TEST(WeavesThroughNoise, ManyTimesTheHandlesThoughFewerVotesObject)
{
    const WeavingSigns real{0.040, 459}, simulated{0.30, 22};
    EXPECT_TRUE(may_weave_through_noise(real));
    EXPECT_TRUE(weaves_through_noise(real, {0.048, 13}));
    EXPECT_TRUE(weaves_through_noise(real, {0.048, 54}));
    EXPECT_FALSE(weaves_through_noise(real, {0.048, 80})) << "handles of its own";
    EXPECT_FALSE(weaves_through_noise(real, {0.081, 13})) << "denoising loses parts";
    EXPECT_TRUE(may_weave_through_noise(simulated));
    EXPECT_FALSE(weaves_through_noise(simulated, {0.11, 10}));
    EXPECT_FALSE(may_weave_through_noise({0.029, 459}));
    EXPECT_FALSE(may_weave_through_noise({0.30, 20}));
}

TEST(MeasureVolume, OfATetrahedronIsASixthOfItsBox)
{
    const TriangleMesh outward{
        {{1, 0, 0}, {3, 0, 0}, {1, 2, 0}, {1, 0, 2}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}, {}};
    EXPECT_NEAR(measure_volume(outward), 8.0 / 6, 1e-12);
    TriangleMesh inward = outward;
    for (auto& t : inward.triangles)
        std::swap(t[0], t[1]);
    EXPECT_NEAR(measure_volume(inward), -8.0 / 6, 1e-12);
}
