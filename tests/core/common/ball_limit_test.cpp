#include <recon/labelling/labelled_balls.h>
#include <recon/mesh/crust_mesh.h>
#include <recon/mesh/mismatch.h>
#include <recon/search/spatial_order.h>

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace recon;

namespace
{

/// A cloud labelled with each limit of its balls.
class Labelled
{
public:
    explicit Labelled(const Points& points)
        : samples_(UnitFrame(points).to_unit(points_at(order_input(points).order, points)))
    {
    }

    LabelledBalls by(BallLimit limit) const
    {
        BallLabellingOptions options;
        options.limit = limit;
        return by(options);
    }
    LabelledBalls by(const BallLabellingOptions& options) const
    {
        PhaseTimes times;
        return label_polar_balls(samples_, {}, options, times);
    }
    /// Share of the samples that the crust misses.
    double missed_by(const LabelledBalls& found) const
    {
        return measure_missed_points(samples_,
                                     triangulate_polygons(list_crust_polygons(found.regular, found.labels, 1), 1));
    }

private:
    Points samples_;
};

} // namespace

// Around them the Voronoi cells are short and the neighbours lie in no plane, as in noise.
TEST(BallLimit, ThinSpikesThatLookNoisyStay)
{
    for (const std::uint64_t seed : {1, 2, 3})
    {
        const Labelled ball(shapes::spiky_ball(2.4, seed));
        const LabelledBalls local = ball.by(BallLimit::local), chosen = ball.by(BallLimit::fewest_votes);
        EXPECT_GT(ball.missed_by(local), 0.02);
        EXPECT_LT(ball.missed_by(chosen), 0.006);
        EXPECT_LT(chosen.violated_votes, 0.3 * local.violated_votes);
    }
}

TEST(BallLimit, ATorusThatIsNoisyInPartIsLabelledByTheLocalScale)
{
    constexpr double major = 1, minor = 0.45, noisy_share = 0.15;
    constexpr int n = 6000;
    Points points = shapes::torus(n, major, minor, 1).points;
    const double spacing = std::sqrt(4 * M_PI * M_PI * major * minor / n);
    const Points noisy = shapes::with_noise(points, 0.8 * spacing, 1);
    for (int i = 0; i < n; ++i)
        if (std::atan2(points[i].y(), points[i].x()) < 2 * M_PI * (noisy_share - 0.5))
            points[i] = noisy[i];
    const Labelled torus(points);
    const double local = torus.by(BallLimit::local).violated_votes, fine = torus.by(BallLimit::fine).violated_votes;
    EXPECT_GT(fine, 2 * local);
    EXPECT_EQ(torus.by(BallLimit::fewest_votes).violated_votes, local);
}

// Balls below it go whatever their surroundings.
TEST(BallLimit, AThresholdLeavesNoChoice)
{
    const Points points = shapes::sphere(500, 1, 1).points;
    BallLabellingOptions options;
    options.ball_threshold = 0.3;
    PhaseTimes times;
    const auto count = [&](BallLimit limit)
    {
        options.limit = limit;
        return label_polar_balls(points, {}, options, times).kept.balls.size();
    };
    EXPECT_EQ(count(BallLimit::fewest_votes), count(BallLimit::local));
}

TEST(BallLimit, LabelsOfNoUseAreNotRepaired)
{
    const Points torus = shapes::torus(4000, 1, 0.3, 3).points;
    const Labelled noisy(shapes::with_noise(torus, 0.3 * std::sqrt(4 * EIGEN_PI * EIGEN_PI * 0.3 / 4000), 5));
    const auto label = [&](double most_violated)
    {
        BallLabellingOptions options;
        options.most_violated = most_violated;
        return noisy.by(options);
    };
    const LabelledBalls repaired = label(1), useless = label(1e-9);
    EXPECT_GT(repaired.violated_votes, 1e-9);
    EXPECT_EQ(repaired.violated_votes, useless.violated_votes);
    EXPECT_LT(repaired.regular.finite_cells, useless.regular.finite_cells) << "doubtful balls were taken out";
    EXPECT_EQ(label(repaired.violated_votes).labels, repaired.labels);
}
