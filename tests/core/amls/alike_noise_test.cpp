#include "filter_amls/fits/alike_noise.h"

#include <gtest/gtest.h>

using namespace recon;

namespace
{

using Means = AlikeMeans<2>;

/// Places without order, of noise 1, 2, 3, 100 and 200, with the noise itself and its square known there.
Means five_places(std::size_t fewest)
{
    return {{100, 2, 1, 200, 3}, {{{100, 1e4}}, {{2, 4}}, {{1, 1}}, {{200, 4e4}}, {{3, 9}}}, fewest};
}

} // namespace

TEST(AlikeNoise, IsWithinTheSameFactorEitherWay)
{
    EXPECT_TRUE(is_alike_noise(1, 2.9));
    EXPECT_TRUE(is_alike_noise(2.9, 1));
    EXPECT_FALSE(is_alike_noise(1, 3.1));
    EXPECT_FALSE(is_alike_noise(3.1, 1));
}

TEST(AlikeNoise, MeansAreOfPlacesInAlikeNoiseAlone)
{
    const Means means = five_places(1);
    EXPECT_EQ(means.around(2), (Means::Values{2, 14. / 3}));
    EXPECT_EQ(means.around(150), (Means::Values{150, 2.5e4}));
}

TEST(AlikeNoise, TooFewArePaddedByTheNext)
{
    EXPECT_EQ(five_places(1).around(1000), (Means::Values{200, 4e4}));
    EXPECT_EQ(five_places(1).around(0.1), (Means::Values{1, 1}));
    EXPECT_DOUBLE_EQ(five_places(3).around(150)[0], 101); // 3 is the next below
    EXPECT_DOUBLE_EQ(five_places(9).around(150)[0], 306. / 5);
}

TEST(AlikeNoise, OfNothingTheyAreZero)
{
    EXPECT_EQ(Means({}, {}, 4).around(1), (Means::Values{0, 0}));
}
