#pragma once

#include "checks.h"
#include "shapes.h"

#include <gtest/gtest.h>

namespace checks
{

/// What both reconstructions must say of hairs that no surface can follow, and not of what bears them. \param
/// reconstruct from points to a result with warnings.
template <class Reconstruct>
void expect_a_word_on_missed_points(const Reconstruct& reconstruct)
{
    const recon::Points points = shapes::with_noise(shapes::ball_with_hairs(3), 0.01, 3);
    EXPECT_TRUE(says(reconstruct(points).warnings, "of the points lie farther"));
    const recon::Points ball(points.begin(), points.begin() + 6'000);
    EXPECT_FALSE(says(reconstruct(ball).warnings, "of the points lie farther"));
}

} // namespace checks
