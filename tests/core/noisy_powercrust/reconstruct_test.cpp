#include "filter_noisy_powercrust/reconstruct.h"

#include "filter_amls/mesh/smooth_mesh.h"

#include "tests/checks.h"
#include "tests/missed_points.h"
#include "tests/shapes.h"

#include <recon/errors.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

using namespace recon;

namespace
{

constexpr double pi = 3.14159265358979323846;

struct Case
{
    const char* name;
    Points points;
    int genus;
    double volume;
    std::function<double(const Point&)> distance;
};

/// Shapes of known volume and genus, without noise and as noisy copies.
std::vector<Case> cases()
{
    std::vector<Case> result;
    for (const double sigma : {0.0, 0.02})
    {
        const auto cloud = [&](const OrientedSamples& samples)
        { return sigma > 0 ? shapes::with_noisy_copies(samples.points, sigma, 4, 9) : samples.points; };
        result.push_back({"sphere", cloud(shapes::sphere(3000, 1, 1)), 0, 4 * pi / 3,
                          [](const Point& p) { return shapes::distance_to_sphere(p, 1); }});
        result.push_back({"torus", cloud(shapes::torus(5000, 1, 0.35, 2)), 1, 2 * pi * pi * 0.35 * 0.35,
                          [](const Point& p) { return shapes::distance_to_torus(p, 1, 0.35); }});
        result.push_back({"box", cloud(shapes::box(6000, Vector(2, 1.5, 1), 3)), 0, 3,
                          [](const Point& p) { return shapes::distance_to_box(p, Vector(2, 1.5, 1)); }});
        result.push_back({"capsule", cloud(shapes::capsule(4000, 0.4, 1, 4)), 0, pi * 0.16 * (2 + 4.0 / 3 * 0.4),
                          [](const Point& p) { return shapes::distance_to_capsule(p, 0.4, 1); }});
    }
    return result;
}

std::vector<NoisyPowerCrustOptions> variants()
{
    std::vector<NoisyPowerCrustOptions> result(4);
    result[1].denoise = Denoise::off;
    result[2].denoise = Denoise::on;
    result[3].smooth = result[3].simplify = false;
    return result;
}

double rms(const TriangleMesh& mesh, const std::function<double(const Point&)>& distance)
{
    double sum = 0;
    for (const Point& p : mesh.vertices)
        sum += distance(p) * distance(p);
    return std::sqrt(sum / double(mesh.vertices.size()));
}

} // namespace

TEST(NoisyPowerCrust, IsClosedOrientedAndOfTheRightGenus)
{
    for (const Case& c : cases())
        for (const NoisyPowerCrustOptions& options : variants())
        {
            SCOPED_TRACE(c.name);
            const NoisyPowerCrust crust = reconstruct_noisy_power_crust(c.points, options);
            const checks::MeshReport report = checks::examine_mesh(crust.mesh);
            EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
            EXPECT_EQ(report.unreferenced_vertices, 0);
            EXPECT_EQ(report.components, 1);
            EXPECT_EQ(report.genus(), c.genus);
            EXPECT_NEAR(report.volume, c.volume, 0.04 * c.volume);
            EXPECT_EQ(crust.components, report.components);
            EXPECT_EQ(crust.euler_characteristic, report.euler_characteristic);
            EXPECT_EQ(crust.genus, report.genus());
            EXPECT_LT(crust.violated_votes, 0.05);
            EXPECT_TRUE(crust.warnings.empty());
            ASSERT_EQ(crust.nearest_sample.size(), crust.mesh.vertices.size());
            for (const int i : crust.nearest_sample)
                ASSERT_TRUE(i >= 0 && i < int(c.points.size()));
            EXPECT_LT(rms(crust.mesh, c.distance), 0.02);
        }
}

TEST(NoisyPowerCrust, DenoisesOnlyWhatIsNoisy)
{
    for (const Case& c : cases())
    {
        SCOPED_TRACE(c.name);
        const bool noisy = c.points.size() > 8000;
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(c.points);
        EXPECT_EQ(crust.denoised, noisy);
        EXPECT_LE(crust.mesh.triangles.size(), 2.1 * crust.samples);
        if (!noisy)
            continue;
        NoisyPowerCrustOptions raw;
        raw.denoise = Denoise::off;
        raw.smooth = false;
        // At least as accurate as the points as they are: half the error.
        EXPECT_LT(rms(crust.mesh, c.distance),
                  0.6 * rms(reconstruct_noisy_power_crust(c.points, raw).mesh, c.distance));
    }
}

TEST(NoisyPowerCrust, KeepsBoresOfThreeSpacingsInNoise)
{
    int open = 0;
    for (const unsigned seed : {1, 2, 3})
    {
        const Points points = shapes::with_noise(shapes::bored_plate(3, 3, seed), 0.3, seed + 10);
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(points);
        EXPECT_TRUE(crust.denoised);
        const checks::MeshReport report = checks::examine_mesh(crust.mesh);
        EXPECT_EQ(report.components, 1);
        EXPECT_LE(report.genus(), 9) << "seed " << seed;
        open += report.genus();
    }
    // Of 27; without normals in the say on short handles 12.
    EXPECT_GE(open, 20);
}

TEST(NoisyPowerCrust, SharesBallsUnlessTheCrustHasToBeFine)
{
    const auto balls_per_sample = [](const Points& points, bool smooth, bool simplify)
    {
        NoisyPowerCrustOptions options;
        options.smooth = smooth;
        options.simplify = simplify;
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(points, options);
        EXPECT_EQ(crust.genus, 1);
        return double(crust.balls_kept) / crust.samples;
    };
    const Points clean = shapes::torus(5000, 1, 0.35, 2).points, noisy = shapes::with_noisy_copies(clean, 0.02, 4, 9);
    EXPECT_LT(balls_per_sample(noisy, true, true), 1);
    EXPECT_LT(balls_per_sample(noisy, false, true), 1);
    EXPECT_GT(balls_per_sample(noisy, true, false), 1.5);
    EXPECT_LT(balls_per_sample(clean, true, true), 1);
    EXPECT_LT(balls_per_sample(clean, false, true), 1);
    EXPECT_GT(balls_per_sample(clean, true, false), 1.5);
}

TEST(NoisyPowerCrust, PassesThroughCleanPointsSmoothedOrNot)
{
    const Points points = shapes::torus(4000, 1, 0.35, 5).points;
    for (const bool smooth : {true, false})
    {
        NoisyPowerCrustOptions options;
        options.smooth = smooth;
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(points, options);
        int on_points = 0;
        for (std::size_t v = 0; v < crust.mesh.vertices.size(); ++v)
            on_points += (crust.mesh.vertices[v] - points[crust.nearest_sample[v]]).norm() < 1e-12;
        EXPECT_GT(on_points, 0.995 * double(points.size()));
        EXPECT_LT(crust.mesh.vertices.size(), 1.005 * double(points.size()));
    }
}

TEST(NoisyPowerCrust, WallsThinnerThanTwoSpacingsAreNoNoise)
{
    constexpr int side = 24;
    constexpr double thickness = 1.5;
    const Points points = shapes::thin_plate(side, thickness, 5);
    const NoisyPowerCrust crust = reconstruct_noisy_power_crust(points);
    EXPECT_FALSE(crust.denoised);
    const checks::MeshReport report = checks::examine_mesh(crust.mesh);
    EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.genus(), 0);
    EXPECT_NEAR(report.volume, side * side * thickness, 0.06 * side * side * thickness);
}

TEST(NoisyPowerCrust, DependsNeitherOnThreadsNorOnOrderNorOnTheRun)
{
    const Points points = shapes::with_noisy_copies(shapes::torus(3000, 1, 0.4, 5).points, 0.02, 4, 6);
    NoisyPowerCrustOptions options;
    options.threads = 1;
    const NoisyPowerCrust one = reconstruct_noisy_power_crust(points, options);
    for (const int threads : {1, 2, 3})
    {
        options.threads = threads;
        Points shuffled = points;
        if (threads == 3)
            std::reverse(shuffled.begin(), shuffled.end());
        const NoisyPowerCrust other = reconstruct_noisy_power_crust(shuffled, options);
        ASSERT_EQ(one.mesh.vertices.size(), other.mesh.vertices.size());
        EXPECT_TRUE(std::equal(one.mesh.vertices.begin(), one.mesh.vertices.end(), other.mesh.vertices.begin()));
        EXPECT_EQ(one.mesh.triangles, other.mesh.triangles);
    }
}

TEST(NoisyPowerCrust, IsTheSameAtAnyOffsetAndScale)
{
    const Points points = shapes::with_noisy_copies(shapes::torus(2000, 1, 0.4, 5).points, 0.01, 4, 6);
    const NoisyPowerCrust expected = reconstruct_noisy_power_crust(points);
    for (const auto& [scale, offset] :
         {std::pair(1.0, 5e6), std::pair(1e-6, 0.0), std::pair(1e-30, 0.0), std::pair(1e30, 0.0)})
    {
        Points moved = points;
        for (Point& p : moved)
            p = scale * p + Point::Constant(offset);
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(moved);
        EXPECT_EQ(crust.euler_characteristic, expected.euler_characteristic);
        EXPECT_EQ(crust.denoised, expected.denoised);
        EXPECT_NEAR(crust.noise / scale, expected.noise, 0.01 * expected.noise);
        EXPECT_NEAR(checks::examine_mesh(crust.mesh).volume / std::pow(scale, 3),
                    checks::examine_mesh(expected.mesh).volume, 0.002);
    }
}

TEST(NoisyPowerCrust, DuplicatesAndOutliersChangeLittle)
{
    const Points clean = shapes::with_noisy_copies(shapes::sphere(3000, 1, 5).points, 0.01, 4, 6);
    Points spoilt = clean;
    for (int copy = 0; copy < 2; ++copy)
        spoilt.insert(spoilt.end(), clean.begin(), clean.begin() + 2000);
    const NoisyPowerCrust same = reconstruct_noisy_power_crust(spoilt), expected = reconstruct_noisy_power_crust(clean);
    EXPECT_EQ(same.points_used, expected.points_used);
    EXPECT_EQ(same.mesh.triangles, expected.mesh.triangles);

    for (const Point& p : shapes::with_noise(shapes::sphere(150, 1.3, 7).points, 0.4, 8))
        spoilt.push_back(p);
    const checks::MeshReport report = checks::examine_mesh(reconstruct_noisy_power_crust(spoilt).mesh);
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.genus(), 0);
    EXPECT_NEAR(report.volume, 4 * pi / 3, 0.05 * 4 * pi / 3);
}

// Meridians that end in sixty points 3e-15 apart, by a pi that was typed: measured there, the samples are so dense that
// nothing else counts.
TEST(NoisyPowerCrust, EndsOfMeridiansDoNotOutweighTheRest)
{
    constexpr int n = 60;
    constexpr double typed_pi = 3.14159265358979;
    Points points;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
        {
            const double u = typed_pi * (double(i) / (n - 1)), v = 2 * typed_pi * (double(j) / n);
            const Point p(std::sin(u) * std::cos(v), std::sin(u) * std::sin(v), std::cos(u));
            points.insert(points.end(), {p, 0.7 * p});
        }
    const checks::MeshReport report = checks::examine_mesh(reconstruct_noisy_power_crust(points).mesh);
    EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
    EXPECT_EQ(report.components, 2);
    EXPECT_NEAR(report.volume, 4 * pi / 3 * (1 - 0.343), 0.03);
}

// Their crust is a cube, half of whose corners are as near to one point as to another: welded at two points, nothing
// would be left.
TEST(NoisyPowerCrust, SixCornersOfAnOctahedronHaveABody)
{
    Points points;
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0})
            points.push_back(side * Vector::Unit(axis));
    const checks::MeshReport report = checks::examine_mesh(reconstruct_noisy_power_crust(points).mesh);
    EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
    EXPECT_EQ(report.euler_characteristic, 2);
    EXPECT_GT(report.volume, 1.33);
}

TEST(NoisyPowerCrust, APointAtAFarOriginCostsTheOthersNothing)
{
    Points points = shapes::with_noisy_copies(shapes::torus(2000, 1, 0.35, 2).points, 0.01, 2, 9);
    points.emplace_back(1e6, 5e5, 0);
    const NoisyPowerCrust crust = reconstruct_noisy_power_crust(points);
    EXPECT_EQ(crust.outliers, 1);
    EXPECT_EQ(crust.genus, 1);
    for (const Point& p : crust.mesh.vertices)
        EXPECT_LT(shapes::distance_to_torus(p, 1, 0.35), 0.06);
}

TEST(NoisyPowerCrust, OutliersAroundCleanPointsMakeNoShell)
{
    const Points torus = shapes::torus(12'000, 1, 0.35, 2).points;
    for (const double share : {0.002, 0.05})
    {
        Points points = torus;
        for (const Point& p : shapes::scattered(int(std::lround(share * double(torus.size()))), {3, 3, 0.8}, 7))
            points.push_back(p);
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(points);
        EXPECT_EQ(crust.components, 1) << share;
        EXPECT_EQ(crust.genus, 1) << share;
        EXPECT_NEAR(checks::examine_mesh(crust.mesh).volume, 2 * EIGEN_PI * EIGEN_PI * 0.35 * 0.35, 0.01) << share;
        EXPECT_GT(crust.outliers, 0.7 * share * double(torus.size()));
    }
}

TEST(NoisyPowerCrust, AsManyOutliersAsNoisyPointsChangeLittle)
{
    for (const auto& [noise, share] : {std::pair{0.0, 0.4}, std::pair{0.01, 1.0}})
    {
        Points points = shapes::with_noise(shapes::torus(12'000, 1, 0.35, 2).points, noise, 3);
        for (const Point& p : shapes::scattered(int(share * double(points.size())), {3, 3, 1.2}, 7))
            points.push_back(p);
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(points);
        EXPECT_EQ(crust.components, 1) << noise;
        EXPECT_EQ(crust.genus, 1) << noise;
        EXPECT_NEAR(checks::examine_mesh(crust.mesh).volume, 2 * EIGEN_PI * EIGEN_PI * 0.35 * 0.35, 0.05) << noise;
        EXPECT_GT(crust.outliers, 0.7 * share * 12'000) << noise;
        EXPECT_TRUE(crust.warnings.empty()) << crust.warnings.front();
    }
}

TEST(NoisyPowerCrust, PapersRuleAndFixedThresholdWork)
{
    const Points points = shapes::torus(4000, 1, 0.4, 5).points;
    NoisyPowerCrustOptions options;
    options.denoise = Denoise::off;
    options.deep_intersection = std::cos(pi / 4);
    options.ball_threshold = 0.1;
    const NoisyPowerCrust crust = reconstruct_noisy_power_crust(points, options);
    EXPECT_GE(crust.smallest_ball, 0.1 * (1 - 1e-12));
    EXPECT_EQ(crust.genus, 1);
    options.noise = 0.01;
    EXPECT_EQ(reconstruct_noisy_power_crust(points, options).noise, 0.01);
}

TEST(NoisyPowerCrust, SmoothingMovesVerticesNoFartherThanNoiseAndSpacing)
{
    const Points cloud = shapes::with_noisy_copies(shapes::sphere(3000, 1, 1).points, 0.01, 4, 2);
    const AmlsSurface surface = build_amls_surface(cloud);
    TriangleMesh mesh = reconstruct_noisy_power_crust(cloud).mesh;
    const double noise = surface.report().noise, spacing = surface.report().spacing;
    // Every tenth vertex is off by what noise explains, every tenth by what it does not.
    const double near = 2 * noise, far = 1.3 * std::max(spacing, 3 * noise);
    for (std::size_t v = 0; v < mesh.vertices.size(); v += 5)
        mesh.vertices[v] *= 1 + (v % 10 == 0 ? near : far);
    const Points before = mesh.vertices;
    smooth_mesh(mesh, surface, 1);
    int stayed = 0, returned = 0, tenth = 0;
    for (std::size_t v = 0; v < before.size(); v += 10, ++tenth)
        returned += std::abs(mesh.vertices[v].norm() - 1) < noise;
    for (std::size_t v = 5; v < before.size(); v += 10)
        stayed += mesh.vertices[v] == before[v];
    EXPECT_GT(returned, 0.95 * tenth);
    EXPECT_GT(stayed, 0.9 * tenth);
}

TEST(NoisyPowerCrust, RefusesWhatItCannotUse)
{
    const auto message = [](const Points& points, const NoisyPowerCrustOptions& options = {}) -> std::string
    {
        try
        {
            reconstruct_noisy_power_crust(points, options);
        }
        catch (const std::exception& e)
        {
            return e.what();
        }
        return "";
    };
    const Points sphere = shapes::sphere(300, 1, 1).points;
    const auto says = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
    EXPECT_TRUE(says(message({}), "points"));
    EXPECT_TRUE(says(message(Points(3, Point(1, 2, 3))), "at least 4"));
    EXPECT_TRUE(says(message(Points(30, Point(1, 2, 3))), "equal"));
    Points line, plane, broken = sphere;
    for (int i = 0; i < 30; ++i)
    {
        line.push_back(i * Point(1, 2, 3));
        plane.push_back(Point(i % 6, i / 6, 0));
    }
    EXPECT_TRUE(says(message(line), "line"));
    EXPECT_TRUE(says(message(plane), "plane"));
    broken[7].y() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(says(message(broken), "Vertex 7"));
    NoisyPowerCrustOptions options;
    options.ball_threshold = 50;
    EXPECT_TRUE(says(message(sphere, options), "ball_threshold"));
    options.ball_threshold = 1.5;
    const Points torus = shapes::torus(4000, 1, 0.4, 1).points;
    EXPECT_TRUE(says(message(shapes::with_noise(torus, 0.01, 1), options), "ball_threshold"));
    EXPECT_TRUE(says(message(shapes::with_noisy_copies(torus, 0.02, 4, 1), options), "ball_threshold"));
    for (const auto& spoil :
         std::vector<std::function<void(NoisyPowerCrustOptions&)>>{
             [](auto& o) { o.ball_threshold = -1; }, [](auto& o) { o.noise = -1; },
             [](auto& o) { o.deep_intersection = 1.5; }, [](auto& o) { o.trim_length = -1; },
             [](auto& o) { o.threads = -2; }})
    {
        NoisyPowerCrustOptions bad;
        spoil(bad);
        EXPECT_THROW(reconstruct_noisy_power_crust(sphere, bad), InvalidInput);
    }
}

TEST(NoisyPowerCrust, SaysThatPointsAreMissed)
{
    checks::expect_a_word_on_missed_points([](const Points& points) { return reconstruct_noisy_power_crust(points); });
}

TEST(NoisyPowerCrust, ReportsProgressAndStopsAnywhere)
{
    const Points points = shapes::with_noisy_copies(shapes::torus(1500, 1, 0.4, 5).points, 0.02, 4, 6);
    NoisyPowerCrustOptions options;
    options.threads = 1; // more share the work, and with it the reports, differently each time
    double last = -1;
    int calls = 0;
    reconstruct_noisy_power_crust(points, options,
                                  Progress(
                                      [&](double fraction, const std::string& phase)
                                      {
                                          EXPECT_GE(fraction, last);
                                          EXPECT_LE(fraction, 1);
                                          EXPECT_FALSE(phase.empty());
                                          last = fraction;
                                          ++calls;
                                          return true;
                                      }));
    EXPECT_GT(last, 0.95);
    ASSERT_GT(calls, 10);
    for (int stop = 1; stop < calls; stop += std::max(1, calls / 12))
    {
        int seen = 0;
        const Progress progress([&](double, const std::string&) { return ++seen < stop; });
        EXPECT_THROW(reconstruct_noisy_power_crust(points, options, progress), Cancelled);
    }
}
