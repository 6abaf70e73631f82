#include "filter_noisy_powercrust/medial_axis.h"

#include "tests/shapes.h"

#include <recon/errors.h>
#include <recon/neighbours.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

using namespace recon;

namespace
{

constexpr double pi = 3.14159265358979323846;

/// Poles, and centres of the edges and triangles between them.
Points sample(const PowerShape& shape)
{
    Points samples = shape.centres;
    const auto& at = shape.centres;
    for (const auto& e : shape.edges)
        samples.push_back((at[e[0]] + at[e[1]]) / 2);
    for (const auto& t : shape.triangles)
    {
        samples.push_back((at[t[0]] + at[t[1]] + at[t[2]]) / 3);
        for (int k = 0; k < 3; ++k)
            samples.push_back((at[t[k]] + at[t[(k + 1) % 3]]) / 2);
    }
    return samples;
}

/// Larger of: farthest sample of the shape from the true axis, farthest sample of the true axis from the shape's.
double hausdorff(const PowerShape& shape, const std::function<double(const Point&)>& distance_to_axis,
                 const Points& on_axis)
{
    double worst = 0;
    const Points samples = sample(shape);
    for (const Point& p : samples)
        worst = std::max(worst, distance_to_axis(p));
    const NeighbourSearch search(samples);
    for (const Point& p : on_axis)
        worst = std::max(worst, (p - samples[search.nearest(p)]).norm());
    return worst;
}

void expect_sound(const PowerShape& shape)
{
    const int n = int(shape.centres.size());
    ASSERT_GT(n, 0);
    EXPECT_EQ(shape.radii.size(), shape.centres.size());
    EXPECT_EQ(shape.nearest_sample.size(), shape.centres.size());
    for (const auto& t : shape.triangles)
        for (int k = 0; k < 3; ++k)
        {
            ASSERT_TRUE(t[k] >= 0 && t[k] < n);
            EXPECT_NE(t[k], t[(k + 1) % 3]);
        }
    for (const auto& e : shape.edges)
        EXPECT_TRUE(e[0] >= 0 && e[0] < e[1] && e[1] < n);
}

} // namespace

TEST(PowerShape, OfATorusIsItsCircle)
{
    const double major = 3, minor = 1;
    const int n = 6000;
    const double spacing = std::sqrt(4 * pi * pi * major * minor / n);
    const Points clean = shapes::torus(n, major, minor, 1).points;
    Points circle;
    for (int k = 0; k < 500; ++k)
        circle.emplace_back(major * std::cos(k * pi / 250), major * std::sin(k * pi / 250), 0);
    const auto distance = [&](const Point& p) { return std::hypot(p.head<2>().norm() - major, p.z()); };
    for (const double sigma : {0.0, 0.03})
    {
        SCOPED_TRACE(sigma);
        const PowerShape shape = compute_power_shape(sigma > 0 ? shapes::with_noisy_copies(clean, sigma, 4, 2) : clean);
        expect_sound(shape);
        EXPECT_EQ(shape.denoised, sigma > 0);
        EXPECT_LT(hausdorff(shape, distance, circle), 1.5 * spacing);
        EXPECT_NEAR(shape.union_volume, 2 * pi * pi * major * minor * minor, 0.015 * shape.union_volume);
        EXPECT_NEAR(shape.union_area, 4 * pi * pi * major * minor, 0.015 * shape.union_area);
        EXPECT_NEAR(shape.largest_radius, minor, 0.1 * minor);
    }
}

TEST(PowerShape, OfACapsuleIsItsSegment)
{
    const double radius = 1, half_length = 2;
    const int n = 5000;
    const double spacing = std::sqrt(4 * pi * radius * (half_length + radius) / n);
    for (const double sigma : {0.0, 0.02})
    {
        Points points = shapes::capsule(n, radius, half_length, 2).points;
        if (sigma > 0)
            points = shapes::with_noisy_copies(points, sigma, 4, 3);
        const PowerShape shape = compute_power_shape(points);
        expect_sound(shape);
        Points segment;
        for (int k = 0; k <= 200; ++k)
            segment.emplace_back(0, 0, half_length * (k / 100.0 - 1));
        const auto distance = [&](const Point& p)
        { return (p - Point(0, 0, std::clamp(p.z(), -half_length, half_length))).norm(); };
        EXPECT_LT(hausdorff(shape, distance, segment), 1.5 * spacing) << "sigma " << sigma;
        EXPECT_EQ(shape.denoised, sigma > 0);
    }
}

TEST(PowerShape, DenoisesEvenALittleNoise)
{
    // One point each, noise a sixth of the spacing: a crust needs no help there, but each bump would make a twig.
    const PowerShape shape = compute_power_shape(shapes::with_noise(shapes::torus(4000, 1, 0.4, 1).points, 0.01, 2));
    EXPECT_TRUE(shape.denoised);
    for (const Point& p : shape.centres)
        EXPECT_LT(std::hypot(p.head<2>().norm() - 1, p.z()), 0.15);
}

TEST(PowerShape, OfABoxReachesIntoItsCorners)
{
    const Vector sides(4, 3, 2);
    const int n = 20000;
    const double spacing = std::sqrt(52.0 / n);
    const Points clean = shapes::box(n, sides, 4).points;
    // A point is on the axis if two faces are equally near: its distances to the two nearest differ by nothing.
    const auto off_axis = [&](const Point& p)
    {
        std::array<double, 6> d;
        for (int k = 0; k < 3; ++k)
        {
            d[2 * k] = sides[k] / 2 - p[k];
            d[2 * k + 1] = sides[k] / 2 + p[k];
        }
        std::sort(d.begin(), d.end());
        return (d[1] - d[0]) / 2;
    };
    Points on_axis;
    for (int i = 0; i <= 40; ++i)
        for (int j = 0; j <= 40; ++j)
            for (int k = 0; k <= 40; ++k)
            {
                const Point p = (Point(i, j, k) / 20 - Point::Ones()).cwiseProduct(sides / 2);
                if (off_axis(p) < 1e-9 && (sides / 2 - p.cwiseAbs()).minCoeff() > 0)
                    on_axis.push_back(p);
            }
    ASSERT_GT(on_axis.size(), 1000u);
    for (const double sigma : {0.0, 0.01})
    {
        SCOPED_TRACE(sigma);
        const PowerShape shape = compute_power_shape(sigma > 0 ? shapes::with_noisy_copies(clean, sigma, 4, 5) : clean);
        expect_sound(shape);
        EXPECT_LT(hausdorff(shape, off_axis, on_axis), 1.5 * spacing);
        EXPECT_NEAR(shape.union_volume, 24, sigma > 0 ? 2 : 1.2) << "balls leave the corners out";
    }
}

TEST(PowerShape, OfAnExactSphereIsItsCentre)
{
    const PowerShape shape = compute_power_shape(shapes::sphere(3000, 1, 5).points);
    ASSERT_FALSE(shape.centres.empty());
    for (std::size_t i = 0; i < shape.centres.size(); ++i)
    {
        EXPECT_LT(shape.centres[i].norm(), 1e-6);
        EXPECT_NEAR(shape.radii[i], 1, 1e-6);
    }
    EXPECT_NEAR(shape.union_volume, 4 * pi / 3, 1e-3);
}

// All poles lie at one place: 4.5 times the Delaunay triangulation's time while each of them looked at all others.
TEST(PowerShape, OfAnExactSphereIsNotQuadratic)
{
    const PowerShape shape = compute_power_shape(shapes::sphere(30000, 1, 1).points);
    const auto seconds = [&](const std::string& phase)
    {
        double sum = 0;
        for (const auto& [name, time] : shape.seconds)
            sum += name == phase ? time : 0;
        return sum;
    };
    EXPECT_GT(seconds("Delaunay triangulation"), 0);
    EXPECT_LT(seconds("power diagram"), 1.5 * seconds("Delaunay triangulation"));
}

TEST(PowerShape, AFarOutlierHardlyChangesTheVolume)
{
    Points points = shapes::with_noise(shapes::torus(3000, 1, 0.4, 1).points, 0.01, 2);
    for (const double far : {10.0, 1000.0})
    {
        points.emplace_back(far, far, far);
        EXPECT_NEAR(compute_power_shape(points).union_volume, 2 * pi * pi * 0.16, 0.2) << far;
        points.pop_back();
    }
}

TEST(PowerShape, SidesAndPruningDoWhatTheySay)
{
    const Points points = shapes::torus(3000, 3, 1, 1).points;
    PowerShapeOptions options;
    options.side = MedialSide::both;
    const PowerShape both = compute_power_shape(points, options);
    options.side = MedialSide::outer;
    const PowerShape outer = compute_power_shape(points, options);
    const PowerShape inner = compute_power_shape(points);
    const auto inside = [](const Point& p) { return std::hypot(p.head<2>().norm() - 3, p.z()) < 1; };
    EXPECT_TRUE(std::all_of(inner.centres.begin(), inner.centres.end(), inside));
    EXPECT_TRUE(std::none_of(outer.centres.begin(), outer.centres.end(), inside));
    EXPECT_EQ(both.centres.size(), inner.centres.size() + outer.centres.size());
    EXPECT_EQ(outer.union_volume, 0);

    options.side = MedialSide::inner;
    options.redundancy = 0.2;
    const PowerShape sparse = compute_power_shape(points, options);
    EXPECT_LT(sparse.centres.size(), inner.centres.size() / 2);
    EXPECT_NEAR(sparse.union_volume, inner.union_volume, 0.1 * inner.union_volume);
    options.redundancy = 0;
    options.object_angle = 150;
    EXPECT_LT(compute_power_shape(points, options).centres.size(), inner.centres.size());
}

TEST(PowerShape, RefusesOptionsOutOfRange)
{
    const Points points = shapes::sphere(200, 1, 1).points;
    for (const auto& spoil :
         std::vector<std::function<void(PowerShapeOptions&)>>{
             [](auto& o) { o.object_angle = 181; }, [](auto& o) { o.redundancy = -0.1; }, [](auto& o) { o.noise = -1; },
             [](auto& o) { o.ball_threshold = NAN; }, [](auto& o) { o.threads = -1; }})
    {
        PowerShapeOptions options;
        spoil(options);
        EXPECT_THROW(compute_power_shape(points, options), InvalidInput);
    }
    PowerShapeOptions options;
    options.ball_threshold = 100;
    EXPECT_THROW(compute_power_shape(points, options), AlgorithmFailure);
}
