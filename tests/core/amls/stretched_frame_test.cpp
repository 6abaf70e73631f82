#include "filter_amls/fits/stretched_frame.h"

#include "tests/shapes.h"

#include <Eigen/Geometry>

#include <gtest/gtest.h>

#include <cmath>

using namespace recon;

namespace
{

constexpr double width = 0.5, sigma = 0.01, plenty = 100;

/// A fit with the bendings k1 and k2 (Q's eigenvalues), k1 along a direction `angle` off the frame's first axis.
QuadricFit bent(double k1, double k2, double angle, double effective = plenty)
{
    const double c = std::cos(angle), s = std::sin(angle), h = width * width;
    QuadricFit fit;
    fit.c = {0, 0, 0, h * (k1 * c * c + k2 * s * s), h * 2 * (k1 - k2) * c * s, h * (k1 * s * s + k2 * c * c)};
    fit.effective = effective;
    fit.valid = true;
    return fit;
}

TangentFrame stretch(const QuadricFit& fit, double noise = sigma)
{
    const TangentFrame frame(Vector(1, 2, 3).normalized());
    return stretch_along_bend(fit, frame, frame.normal, width, noise);
}

double height(const QuadricFit& fit, const TangentFrame& frame, const Vector& d)
{
    const double u = d.dot(frame.t1) / width, v = d.dot(frame.t2) / width;
    return fit.c[0] + fit.c[1] * u + fit.c[2] * v + fit.c[3] * u * u + fit.c[4] * u * v + fit.c[5] * v * v;
}

} // namespace

TEST(StretchedFrame, IsLongAlongTheBendAndHoldsAsMuch)
{
    const TangentFrame round(Vector(1, 2, 3).normalized());
    const double hidden = sigma / (width * width), angle = 0.7;
    const Vector across = std::cos(angle) * round.t1 + std::sin(angle) * round.t2;
    for (const double k1 : {-0.045, 0.045})
        for (const double k2 : {-0.03, 0.0, 0.02})
        {
            const TangentFrame frame = stretch(bent(k1, k2, angle));
            EXPECT_NEAR(frame.t1.cross(frame.t2).dot(round.normal), 1, 1e-12);
            EXPECT_NEAR(frame.t1.dot(frame.t2), 0, 1e-12);
            // Lengths told across the bend grow: there the window is narrow.
            const double squared =
                frame.t1.dot(across) * frame.t1.dot(across) + frame.t2.dot(across) * frame.t2.dot(across);
            EXPECT_NEAR(squared, std::pow((std::abs(k1) + hidden) / (std::abs(k2) + hidden), 1.5), 1e-6);
            EXPECT_NEAR(stretch_of(frame), std::sqrt(squared), 1e-12);
        }
}

TEST(StretchedFrame, StaysRoundWhereNothingIsGained)
{
    EXPECT_NEAR(stretch_of(stretch(bent(0, 0, 0))), 1, 1e-12);
    EXPECT_NEAR(stretch_of(stretch(bent(2, 2, 0.3))), 1, 1e-12);
    EXPECT_NEAR(stretch_of(stretch(bent(2, -2, 0.3))), 1, 1e-7);     // a saddle is as narrow both ways
    EXPECT_NEAR(stretch_of(stretch(bent(2, 0, 0.3), 1e2)), 1, 0.01); // noise hides the bend
    EXPECT_NEAR(stretch_of(stretch(bent(2, 0, 0.3, 8))), 1, 1e-12);  // too few points
    EXPECT_NEAR(stretch_of(stretch(bent(2, 0, 0.3, 16))), std::sqrt(2), 1e-12);
    EXPECT_NEAR(stretch_of(stretch(bent(2, 0, 0.3))), most_stretch, 1e-12);
    QuadricFit broken = bent(2, 0, 0.3);
    broken.c[3] = std::nan("");
    EXPECT_NEAR(stretch_of(stretch(broken)), 1, 1e-12);
}

TEST(StretchedFrame, TellsTheSameBending)
{
    const TangentFrame round(Vector(1, 2, 3).normalized());
    const QuadricFit fit = bent(1.5, -0.4, 0.7);
    const TangentFrame first = stretch(fit), second = stretch(bent(0.1, 0.8, 0.2));
    const QuadricFit told = with_bending_in(first, fit, round), again = with_bending_in(second, told, first);
    shapes::Random random(1);
    for (int i = 0; i < 20; ++i)
    {
        const Vector d = shapes::uniform(random) * round.t1 - shapes::uniform(random) * round.t2;
        EXPECT_NEAR(height(told, first, d), height(fit, round, d), 1e-12);
        EXPECT_NEAR(height(again, second, d), height(fit, round, d), 1e-12);
        EXPECT_NEAR(d.dot(bending_of(told, first, width) * d), height(fit, round, d), 1e-12);
    }
}

TEST(GatherFacing, TakesWhatLiesInTheStretchedBallAndFacesTheWay)
{
    shapes::Random random(2);
    const auto anywhere = [&] { return shapes::draw_vector([&] { return 2 * shapes::uniform(random) - 1; }); };
    Points points;
    Vectors directions;
    std::vector<double> weights;
    std::vector<int> all_indices;
    for (int i = 0; i < 1003; ++i)
    {
        points.push_back(anywhere());
        directions.push_back(anywhere().normalized());
        weights.push_back(i % 7 == 0 ? 0 : 1 + i);
        all_indices.push_back(i);
    }
    Gathered all, chosen;
    all.gather(points, weights, all_indices, Point::Zero());
    all.gather_directions(directions, all_indices);
    const TangentFrame frame = stretch(bent(2, 0, 0.4));
    const Point origin(0.1, -0.2, 0.1);
    const Vector normal = Vector(1, 1, 0).normalized();
    chosen.gather_facing(all, origin, frame, 0.9, normal, 0.35);
    std::vector<float> expected;
    for (std::size_t i = 0; i < points.size(); ++i)
    {
        const Vector d = points[i] - origin;
        const Vector told(d.dot(frame.t1), d.dot(frame.t2), d.dot(frame.normal));
        if (weights[i] > 0 && told.norm() <= 0.9 && directions[i].dot(normal) > 0.35)
            expected.push_back(float(weights[i]));
    }
    ASSERT_GT(expected.size(), 50u);
    ASSERT_EQ(chosen.size, int(expected.size()));
    for (std::size_t i = 0; i < chosen.weight.size(); ++i)
        EXPECT_EQ(chosen.weight[i], i < expected.size() ? expected[i] : 0);
}
