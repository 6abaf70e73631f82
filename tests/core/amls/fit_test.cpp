#include "filter_amls/fits/fit.h"

#include <recon/errors.h>
#include <recon/search/spatial_order.h>

#include "tests/shapes.h"

#include <Eigen/Geometry>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

using namespace recon;

namespace
{

constexpr double least_squares = 20; // sigmas: no point loses weight

/// Samples with what a search of them needs, in spatial order; all face `normals`.
struct Cloud
{
    Points points;
    Vectors normals;
    std::vector<double> weights;
    BlockSearch search;

    explicit Cloud(const OrientedSamples& samples)
    {
        for (const int i : order_spatially(samples.points).order)
        {
            points.push_back(samples.points[i]);
            normals.push_back(samples.normals[i]);
        }
        weights.assign(points.size(), 1);
        search = BlockSearch(points);
    }
    std::vector<Anchor> fit(const std::vector<FitStart>& starts, double robust_scale = least_squares,
                            int threads = 1) const
    {
        return fit_anchors({points, search, weights, normals}, starts, robust_scale, threads);
    }
};

/// A square of 41 x 41 jittered samples at a height, one a unit of area, all facing the same way.
OrientedSamples sheet(double height, const Vector& normal, std::uint64_t seed)
{
    shapes::Random random(seed);
    std::uniform_real_distribution<double> jitter(-0.3, 0.3);
    OrientedSamples samples;
    for (int i = -20; i <= 20; ++i)
        for (int j = -20; j <= 20; ++j)
        {
            const double x = i + jitter(random);
            samples.points.emplace_back(x, j + jitter(random), height);
            samples.normals.push_back(normal);
        }
    return samples;
}

OrientedSamples both(OrientedSamples a, const OrientedSamples& b)
{
    a.points.insert(a.points.end(), b.points.begin(), b.points.end());
    a.normals.insert(a.normals.end(), b.normals.begin(), b.normals.end());
    return a;
}

/// Anchors on a grid well within the square.
std::vector<FitStart> starts_at_height(double height, double width, double sigma)
{
    std::vector<FitStart> starts;
    for (int x = -10; x <= 10; x += 2)
        for (int y = -10; y <= 10; y += 2)
            starts.push_back({Point(x, y, height), Vector::UnitZ(), width, sigma});
    return starts;
}

double mean_height(const std::vector<Anchor>& anchors)
{
    double sum = 0;
    for (const Anchor& a : anchors)
        sum += a.position.z();
    return sum / double(anchors.size());
}

} // namespace

TEST(FitAnchors, FindPlaceNormalAndCurvatureOfASphere)
{
    const Cloud sphere(shapes::sphere(20000, 1, 1));
    std::vector<FitStart> starts;
    shapes::Random random(2);
    std::normal_distribution<double> normal;
    for (const Vector& n : shapes::sphere(60, 1, 3).normals)
    {
        // Off the surface and some 20 degrees off its normal.
        const Vector tilt = 0.25 * shapes::draw_vector([&] { return normal(random); });
        starts.push_back({n * (1 + 0.02 * normal(random)), (n + tilt).normalized(), 0.15, 0.02});
        if (starts.back().normal.dot(n) < 0.8)
            starts.pop_back();
    }
    ASSERT_GT(starts.size(), 30u);
    for (const Anchor& a : sphere.fit(starts))
    {
        const Vector out = a.position.normalized();
        EXPECT_NEAR(a.position.norm(), 1, 2e-4);
        EXPECT_LT(std::acos(std::min(1.0, a.normal.dot(out))), 0.01);
        // u.n = u^T Q u: -1/2 in every direction along the surface, 0 across it.
        Eigen::Matrix3d q;
        q << a.bending[0], a.bending[3], a.bending[4], a.bending[3], a.bending[1], a.bending[5], a.bending[4],
            a.bending[5], a.bending[2];
        EXPECT_LT((q + 0.5 * (Eigen::Matrix3d::Identity() - out * out.transpose())).norm(), 0.06);
        EXPECT_EQ(a.width, 0.15);
        EXPECT_GT(a.confidence, 20);
    }
}

// Ridges as narrow as the windows: round ones take in the slopes, or too little of the ridge.
TEST(FitAnchors, WindowsFollowRidges)
{
    const double width = 3, noise = 0.1, turn = M_PI / 9, rise = 1.5;
    const Vector along = Vector(0.8, 0.6, 0), across(-0.6, 0.8, 0);
    const auto height = [&](const Point& p) { return rise * std::cos(turn * p.dot(across)); };
    OrientedSamples ridges = sheet(0, Vector::UnitZ(), 8);
    for (std::size_t i = 0; i < ridges.points.size(); ++i)
    {
        Point& p = ridges.points[i];
        p.z() = height(p);
        ridges.normals[i] = (Vector::UnitZ() + rise * turn * std::sin(turn * p.dot(across)) * across).normalized();
    }
    std::vector<FitStart> starts;
    for (int i = -10; i <= 10; ++i)
        starts.push_back({0.8 * i * along + rise * Vector::UnitZ(), Vector::UnitZ(), width, noise});
    double bias = 0, squares = 0;
    int count = 0;
    for (std::uint64_t seed = 11; seed < 31; ++seed)
    {
        OrientedSamples noisy = ridges;
        noisy.points = shapes::with_noise(ridges.points, noise, seed);
        for (const Anchor& anchor : Cloud(noisy).fit(starts))
        {
            const double error = anchor.position.z() - height(anchor.position);
            bias += error;
            squares += error * error;
            ++count;
        }
    }
    EXPECT_LT(std::abs(bias / count), 0.015);      // 0.037 with round windows
    EXPECT_LT(std::sqrt(squares / count), 0.0285); // 0.045; with the samples of round windows 0.030
}

TEST(FitAnchors, ListenOnlyToSamplesThatFaceTheirWay)
{
    // The other side of a plate half a width thick, and samples that weigh nothing.
    const double width = 3;
    const OrientedSamples top = sheet(0, Vector::UnitZ(), 4);
    const Cloud plate(both(top, sheet(-0.5 * width, -Vector::UnitZ(), 5))),
        same_way(both(top, sheet(-0.5 * width, Vector::UnitZ(), 5)));
    Cloud weightless(both(top, sheet(-0.5 * width, Vector::UnitZ(), 5)));
    for (std::size_t i = 0; i < weightless.points.size(); ++i)
        weightless.weights[i] = weightless.points[i].z() < -0.1 ? 0 : 1;
    const std::vector<FitStart> starts = starts_at_height(0, width, 0.01);
    EXPECT_NEAR(mean_height(plate.fit(starts)), 0, 1e-5);
    EXPECT_NEAR(mean_height(weightless.fit(starts)), 0, 1e-5);
    EXPECT_LT(mean_height(same_way.fit(starts)), -0.1 * width);
}

TEST(FitAnchors, LetGoodPointsDecideAtASmallScale)
{
    // A sixth of the samples lies 4 sigma above the others.
    OrientedSamples samples = sheet(0, Vector::UnitZ(), 6);
    const double sigma = 0.2;
    for (std::size_t i = 0; i < samples.points.size(); i += 6)
        samples.points[i].z() = 4 * sigma;
    const Cloud cloud(samples);
    const std::vector<FitStart> starts = starts_at_height(0.1, 3, sigma);
    EXPECT_NEAR(mean_height(cloud.fit(starts)), 4 * sigma / 6, 0.1 * sigma);
    EXPECT_NEAR(mean_height(cloud.fit(starts, 0.5)), 0, 0.01 * sigma);
}

TEST(FitAnchors, StayPlanesWhereTheFitLeadsAway)
{
    const Cloud plane(sheet(0, Vector::UnitZ(), 7));
    const double width = 3;
    // Within 0.4 widths, or 2.5 sigmas, they follow; farther they stay where they were.
    for (const Anchor& a : plane.fit(starts_at_height(0.35 * width, width, 0.01)))
        EXPECT_NEAR(a.position.z(), 0, 1e-5);
    for (const Anchor& a : plane.fit(starts_at_height(0.6 * width, width, 0.3 * width)))
        EXPECT_NEAR(a.position.z(), 0, 1e-5);
    const std::vector<FitStart> far = starts_at_height(0.6 * width, width, 0.01);
    const std::vector<Anchor> stayed = plane.fit(far);
    for (std::size_t i = 0; i < far.size(); ++i)
    {
        EXPECT_EQ(stayed[i].position, far[i].foot);
        EXPECT_EQ(stayed[i].normal, far[i].normal);
        EXPECT_EQ(stayed[i].bending, (std::array<double, 6>{}));
    }
    // So they do if it turns them by over 60 degrees.
    const auto turned = [](double degrees)
    { return Vector(std::sin(degrees * M_PI / 180), 0, std::cos(degrees * M_PI / 180)); };
    std::vector<FitStart> tilted = starts_at_height(0, width, 0.01);
    for (FitStart& start : tilted)
        start.normal = turned(50);
    EXPECT_GT(plane.fit(tilted).front().normal.z(), 0.99);
    for (FitStart& start : tilted)
        start.normal = turned(65);
    EXPECT_EQ(plane.fit(tilted).front().normal, tilted.front().normal);
    // The farther a fit moved, the less it counts.
    EXPECT_LT(plane.fit(starts_at_height(0.35 * width, width, 0.01)).front().confidence,
              0.75 * plane.fit(starts_at_height(0, width, 0.01)).front().confidence);
}

TEST(FitAnchors, DoubtFitsOfTooFewPoints)
{
    OrientedSamples few;
    for (const Point& p : {Point(0, 0, 0), Point(1, 0, 0), Point(0, 1, 0)})
    {
        few.points.push_back(p);
        few.normals.push_back(Vector::UnitZ());
    }
    const Cloud cloud(few);
    const FitStart start{Point(0.2, 0.2, 0.1), Vector::UnitZ(), 2, 0.1},
        nowhere{Point(50, 0, 0), Vector::UnitX(), 2, 1};
    const std::vector<Anchor> anchors = cloud.fit({start, nowhere});
    EXPECT_LE(anchors[0].confidence, 3);
    EXPECT_TRUE(anchors[0].position.allFinite());
    EXPECT_EQ(anchors[1].position, nowhere.foot);
    EXPECT_EQ(anchors[1].normal, nowhere.normal);
    EXPECT_EQ(anchors[1].confidence, 0);
    EXPECT_TRUE(cloud.fit({}).empty());
}

TEST(FitAnchors, DoNotDependOnThreads)
{
    const Cloud cloud(shapes::torus(5000, 1, 0.4, 8));
    std::vector<FitStart> starts;
    for (std::size_t i = 0; i < cloud.points.size(); i += 10)
        starts.push_back({cloud.points[i], cloud.normals[i], 0.15, 0.01});
    const std::vector<Anchor> one = cloud.fit(starts, 1, 1), three = cloud.fit(starts, 1, 3);
    for (std::size_t i = 0; i < starts.size(); ++i)
    {
        EXPECT_EQ(one[i].position, three[i].position);
        EXPECT_EQ(one[i].normal, three[i].normal);
        EXPECT_EQ(one[i].bending, three[i].bending);
        EXPECT_EQ(one[i].confidence, three[i].confidence);
    }
    EXPECT_THROW(fit_anchors({cloud.points, cloud.search, cloud.weights, cloud.normals}, starts, 1, 1,
                             Progress([](double, const std::string&) { return false; })),
                 Cancelled);
}
