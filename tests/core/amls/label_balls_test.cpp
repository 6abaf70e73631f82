#include "filter_amls/sides/label_balls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

using namespace recon;

namespace
{

constexpr int side = 30;

int ball_at(int x, int y)
{
    return y * side + x;
}

/// A grid of balls, the left half outside; some ties tell the contrary of the truth, seldom with much certainty.
std::vector<Tie> grid_of_ties(double wrong_share, unsigned seed)
{
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(0, 1);
    std::vector<Tie> ties;
    for (int y = 0; y < side; ++y)
        ties.push_back({ball_at(0, y), side * side, 2, false});
    const auto add = [&](int x0, int y0, int x1, int y1)
    {
        const bool truth = (x0 < side / 2) != (x1 < side / 2), wrong = uniform(random) < wrong_share;
        ties.push_back({ball_at(x0, y0), ball_at(x1, y1), 0.1f + (wrong ? 0.6f : 1) * uniform(random), truth != wrong});
    };
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x)
        {
            if (x + 1 < side)
                add(x, y, x + 1, y);
            if (y + 1 < side)
                add(x, y, x, y + 1);
            if (x + 1 < side && y + 1 < side)
                add(x, y, x + 1, y + 1);
        }
    return ties;
}

} // namespace

TEST(LabelBalls, ManyTiesOutweighOneThatIsMoreCertain)
{
    // Two chains that belong together, with many ties between them and a heavier one that denies it.
    const int n = 20;
    std::vector<Tie> ties = {{0, 2 * n, 2, false}, {0, n, 0.95f, true}};
    for (int i = 0; i < n; ++i)
    {
        ties.push_back({i, n + i, 0.5f, false});
        if (i > 0)
        {
            ties.push_back({i - 1, i, 0.9f, false});
            ties.push_back({n + i - 1, n + i, 0.9f, false});
        }
    }
    const BallLabels labels = label_balls(2 * n, ties, 1);
    for (int i = 0; i < 2 * n; ++i)
        EXPECT_EQ(labels.side[i], 1) << i;
    EXPECT_NEAR(labels.contradicted, 0.95 / (2 + 0.95 + 0.5 * n + 2 * 0.9 * (n - 1)), 1e-6);
}

TEST(LabelBalls, FindsTheSidesAmongWrongTies)
{
    for (unsigned seed : {1, 2, 3, 4, 5})
    {
        const std::vector<Tie> ties = grid_of_ties(0.05, seed);
        const BallLabels labels = label_balls(side * side, ties, 2);
        int wrong = 0;
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x)
                wrong += labels.side[ball_at(x, y)] != (x < side / 2 ? 1 : -1);
        EXPECT_LE(wrong, 0.02 * side * side) << seed;
        EXPECT_LT(labels.contradicted, 0.06) << seed;
    }
}

TEST(LabelBalls, SeldomMissesTheLeastViolation)
{
    // Small enough to try all labels. From the plain forest alone more instances end in a worse place.
    constexpr int n = 12, instances = 300;
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform(0, 1);
    int missed = 0;
    for (int instance = 0; instance < instances; ++instance)
    {
        std::vector<Tie> ties;
        for (int k = 0; k < 30; ++k)
        {
            const int a = int(random() % (n + 1)), b = int(random() % n);
            if (a != b)
                ties.push_back({b, a, 0.05f + uniform(random), random() % 2 == 0});
        }
        double total = 0, least = 1e300;
        for (const Tie& tie : ties)
            total += tie.weight;
        for (int labels = 0; labels < 1 << n; ++labels) // bit n, the outside, is 0
        {
            double violated = 0;
            for (const Tie& tie : ties)
                violated += (((labels >> tie.a) ^ (labels >> tie.b)) & 1) != int(tie.opposite) ? tie.weight : 0;
            least = std::min(least, violated);
        }
        missed += label_balls(n, ties, 1).contradicted * total > least + 1e-4;
    }
    EXPECT_LT(missed, 0.065 * instances);
}

TEST(LabelBalls, WhatNothingTiesToTheOutsideIsInside)
{
    const BallLabels labels = label_balls(4, {{0, 4, 2, false}, {0, 1, 1, true}, {2, 3, 1, false}}, 1);
    EXPECT_EQ(labels.side, (std::vector<std::int8_t>{1, -1, -1, -1}));
    EXPECT_EQ(label_balls(2, {}, 1).side, (std::vector<std::int8_t>{-1, -1}));
}
