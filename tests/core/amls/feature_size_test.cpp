#include "filter_amls/paper/delaunay_ball_normals.h"
#include "filter_amls/surface/local_feature_size.h"
#include "filter_amls/surface/project.h"

#include <recon/errors.h>

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

using namespace recon;

namespace
{

constexpr double major_radius = 1, minor_radius = 0.4;

/// The medial axis of a torus is the circle inside the tube and the axis of rotation.
double torus_feature_size(const Point& p)
{
    const double ring = p.head<2>().norm();
    return std::min(std::hypot(ring - major_radius, p.z()), ring);
}

/// The medial axis of an ellipsoid a > b > c is the ellipse in its main plane that the curvature centres bound.
double ellipsoid_feature_size(const Point& p, const Vector& axes)
{
    const double rx = (axes[0] * axes[0] - axes[2] * axes[2]) / axes[0],
                 ry = (axes[1] * axes[1] - axes[2] * axes[2]) / axes[1];
    double best = 1e300;
    const int steps = 200;
    for (int i = 0; i <= steps; ++i)
        for (int j = 0; j < 4 * steps; ++j)
        {
            const double r = i / double(steps), angle = M_PI * j / (2 * steps);
            best = std::min(best, (p - Point(r * rx * std::cos(angle), r * ry * std::sin(angle), 0)).squaredNorm());
        }
    return std::sqrt(best);
}

template <class Truth>
double median_relative_error(const std::vector<double>& found, const Points& at, const Truth& truth)
{
    std::vector<double> errors;
    for (std::size_t i = 0; i < at.size(); i += 1 + at.size() / 300)
        errors.push_back(std::abs(found[i] / truth(at[i]) - 1));
    std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
    return errors[errors.size() / 2];
}

std::vector<double> feature_size_of(const Points& cloud)
{
    const AmlsSurface surface = build_amls_surface(cloud);
    return find_local_feature_size(project_to_amls(cloud, surface).points, surface).at_query;
}

} // namespace

// An epsilon-sample at epsilon = 0.1 has spacings of about a tenth of the feature size.
TEST(LocalFeatureSize, MatchesTheTorus)
{
    const Points torus = shapes::torus(20000, major_radius, minor_radius, 1).points;
    EXPECT_LT(median_relative_error(feature_size_of(torus), torus, torus_feature_size), 0.10);
    EXPECT_LT(median_relative_error(feature_size_of(shapes::with_noise(torus, 0.01, 2)), torus, torus_feature_size),
              0.25);
}

TEST(LocalFeatureSize, MatchesTheEllipsoid)
{
    const Vector axes(1.5, 1, 0.6);
    const Points ellipsoid = shapes::ellipsoid(20000, axes, 3).points;
    const auto truth = [&](const Point& p) { return ellipsoid_feature_size(p, axes); };
    EXPECT_LT(median_relative_error(feature_size_of(ellipsoid), ellipsoid, truth), 0.10);
    EXPECT_LT(median_relative_error(feature_size_of(shapes::with_noise(ellipsoid, 0.01, 4)), ellipsoid, truth), 0.25);
}

TEST(LocalFeatureSize, IsLipschitzAndSmoothingKeepsItsLevel)
{
    const Points points = shapes::torus(6000, major_radius, minor_radius, 5).points;
    const AmlsSurface surface = build_amls_surface(points);
    FeatureSizeOptions options;
    const std::vector<double> raw = find_local_feature_size(points, surface, options).at_query;
    for (std::size_t i = 1; i < points.size(); ++i)
        ASSERT_LE(std::abs(raw[i] - raw[i - 1]), (points[i] - points[i - 1]).norm() * (1 + 1e-9));
    options.smoothing = 20;
    const std::vector<double> smooth = find_local_feature_size(points, surface, options).at_query;
    double sum_raw = 0, sum_smooth = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
    {
        sum_raw += raw[i];
        sum_smooth += smooth[i];
    }
    EXPECT_NEAR(sum_smooth / sum_raw, 1, 0.02);
    EXPECT_NE(raw, smooth);
    options.smoothing = -1;
    EXPECT_THROW(find_local_feature_size(points, surface, options), InvalidInput);
}

TEST(LocalFeatureSize, MoreNeighboursThanPointsAreAllPoints)
{
    const Points points = shapes::torus(500, major_radius, minor_radius, 5).points;
    FeatureSizeOptions options;
    options.smoothing = std::numeric_limits<int>::max();
    const std::vector<double> smooth = find_local_feature_size(points, build_amls_surface(points), options).at_query;
    for (const double size : smooth)
        EXPECT_NEAR(size, smooth.front(), 1e-9);
    DelaunayBallOptions normals;
    normals.neighbours = std::numeric_limits<int>::max();
    normals.big_ball_ratio = 0.2;
    EXPECT_EQ(find_delaunay_ball_normals(points, normals).normals.size(), points.size());
}

TEST(DelaunayBallNormals, PointOutwardWithAndWithoutNoise)
{
    const OrientedSamples torus = shapes::torus(8000, major_radius, minor_radius, 6);
    // From a tenth of the spacing to most of it.
    for (double sigma : {0.0, 0.004, 0.01, 0.02, 0.03})
    {
        const DelaunayBallNormals found = find_delaunay_ball_normals(shapes::with_noise(torus.points, sigma, 7));
        ASSERT_EQ(found.normals.size(), torus.points.size());
        int right = 0;
        for (std::size_t i = 0; i < torus.points.size(); ++i)
        {
            ASSERT_NEAR(found.normals[i].norm(), 1, 1e-9);
            right += found.normals[i].dot(torus.normals[i]) > 0.5;
        }
        EXPECT_GT(right / 8000.0, 0.99) << sigma;
        EXPECT_GT(found.poles.size(), 1000u);
    }
}

TEST(DelaunayBallNormals, RefuseBadInput)
{
    const Points points = shapes::sphere(200, 1, 8).points;
    DelaunayBallOptions options;
    options.big_ball_ratio = -1;
    EXPECT_THROW(find_delaunay_ball_normals(points, options), InvalidInput);
    options = {};
    options.neighbours = -1;
    EXPECT_THROW(find_delaunay_ball_normals(points, options), InvalidInput);
    options = {};
    options.normal_spread = 0;
    EXPECT_THROW(find_delaunay_ball_normals(points, options), InvalidInput);
    options = {};
    options.big_ball_ratio = 1e9;
    EXPECT_THROW(find_delaunay_ball_normals(points, options), AlgorithmFailure);
    EXPECT_THROW(find_delaunay_ball_normals({}), InvalidInput);
    EXPECT_THROW(find_delaunay_ball_normals(points, {}, Progress([](double, const std::string&) { return false; })),
                 Cancelled);
}

// With a thousand neighbours both take most of the time.
TEST(FeatureSize, SmoothingAndTheSizeOfBigBallsCanBeCancelled)
{
    const Points points = shapes::sphere(5'000, 1, 8).points;
    FeatureSizeOptions smooth;
    smooth.smoothing = 10;
    EXPECT_THROW(measure_feature_size(points, {Point::Zero()}, smooth,
                                      Progress([](double fraction, const std::string&) { return fraction < 0.5; })),
                 Cancelled);
    const auto is_asked = [](double, const std::string& phase) { return phase != "Size of big balls"; };
    EXPECT_THROW(find_delaunay_ball_normals(points, {}, Progress(is_asked)), Cancelled);
}
