#include "filter_pn_refine/patch/pn_triangle.h"

#include "filter_pn_refine/step/kernels.h"

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace
{

using recon::PointNormal;
using Vec = recon::Vec3<double>;
using Corner = PointNormal<double>;

struct Triangle
{
    Corner a, b, c;
};

/// Triangles of moderate size with normals within about 40 degrees of each other.
Triangle random_triangle(std::mt19937& random)
{
    std::uniform_real_distribution<double> u(-0.4, 0.4);
    const auto draw = [&] { return u(random); };
    const auto corner = [&](double x, double y)
    {
        const Vec position = Vec(x, y, 0) + shapes::draw_vector(draw);
        return Corner{position, shapes::draw_pair(draw).homogeneous().normalized()};
    };
    return {corner(0, 0), corner(2, 0), corner(0, 2)};
}

TEST(PnTriangle, CentreIsThePatchAtOneThird)
{
    std::mt19937 random(1);
    for (int i = 0; i < 100; ++i)
    {
        const Triangle t = random_triangle(random);
        const Vec centre =
            recon::pn_centre(t.a.position, t.b.position, t.c.position, recon::pn_tangents(t.a, t.b, t.c));
        EXPECT_LT((centre - recon::pn_point(t.a, t.b, t.c, 1.0 / 3, 1.0 / 3)).norm(), 1e-14);
    }
}

TEST(PnTriangle, NormalAgreesWithFiniteDifferencesOfThePatch)
{
    std::mt19937 random(2);
    constexpr double h = 1e-5, third = 1.0 / 3;
    for (int i = 0; i < 100; ++i)
    {
        const Triangle t = random_triangle(random);
        const auto at = [&](double u, double v) { return recon::pn_point(t.a, t.b, t.c, u, v); };
        const Vec du = (at(third + h, third) - at(third - h, third)) / (2 * h);
        const Vec dv = (at(third, third + h) - at(third, third - h)) / (2 * h);
        const Vec normal =
            recon::pn_centre_normal(t.a.position, t.b.position, t.c.position, recon::pn_tangents(t.a, t.b, t.c));
        EXPECT_LT(normal.normalized().cross(du.cross(dv).normalized()).norm(), 1e-8);
        EXPECT_GT(normal.dot(du.cross(dv)), 0);
    }
}

TEST(PnTriangle, PatchInterpolatesItsCornersAndBordersAreCurves)
{
    std::mt19937 random(3);
    for (int i = 0; i < 20; ++i)
    {
        const Triangle t = random_triangle(random);
        EXPECT_LT((recon::pn_point(t.a, t.b, t.c, 0.0, 0.0) - t.a.position).norm(), 1e-15);
        EXPECT_LT((recon::pn_point(t.a, t.b, t.c, 1.0, 0.0) - t.b.position).norm(), 1e-15);
        for (double u : {0.2, 0.5, 0.9})
            EXPECT_LT((recon::pn_point(t.a, t.b, t.c, u, 0.0) - recon::pn_curve_point(t.a, t.b, u)).norm(), 1e-14);
    }
}

TEST(PnTriangle, TangentsLieInThePlaneAndAreAThirdOfTheEdge)
{
    std::mt19937 random(4);
    for (int i = 0; i < 100; ++i)
    {
        const Triangle t = random_triangle(random);
        const Vec tangent = recon::pn_tangent(t.a, t.b.position);
        EXPECT_NEAR(tangent.dot(t.a.normal), 0, 1e-14);
        EXPECT_NEAR(tangent.norm(), (t.b.position - t.a.position).norm() / 3, 1e-14);
    }
    EXPECT_EQ(recon::pn_tangent(Corner{Vec::Zero(), Vec::UnitZ()}, Vec(0, 0, 2)).norm(), 0);
}

TEST(PnTriangle, GeodesicDistanceIsCloseToTheLengthOfTheCurve)
{
    std::mt19937 random(5);
    for (int i = 0; i < 100; ++i)
    {
        const Triangle t = random_triangle(random);
        double length = 0;
        constexpr int parts = 2000;
        for (int k = 0; k < parts; ++k)
            length += (recon::pn_curve_point(t.a, t.b, double(k + 1) / parts) -
                       recon::pn_curve_point(t.a, t.b, double(k) / parts))
                          .norm();
        const double polygon = recon::geodesic_distance(t.a, t.b);
        EXPECT_GE(polygon, length * (1 - 1e-6)); // a control polygon is never shorter
        EXPECT_LT(polygon, length * 1.3);
    }
}

TEST(PnTriangle, GeodesicDistanceOnASphereIsItsArc)
{
    for (double angle : {0.1, 0.4, 0.8})
    {
        const Corner a{Vec::UnitZ(), Vec::UnitZ()};
        const Vec p(std::sin(angle), 0, std::cos(angle));
        EXPECT_NEAR(recon::geodesic_distance(a, Corner{p, p}), angle, 0.06 * angle * angle * angle);
    }
}

TEST(PnTriangle, CurvedAngleIsTheAngleThatTheCurveSweeps)
{
    std::mt19937 random(6);
    for (int i = 0; i < 100; ++i)
    {
        const Triangle t = random_triangle(random);
        // The control polygon seen from the apex sweeps at least what the curve does, and on such triangles not much
        // more.
        double swept = 0;
        constexpr int parts = 2000;
        for (int k = 0; k < parts; ++k)
            swept +=
                recon::angle_between<double>(recon::pn_curve_point(t.b, t.c, double(k) / parts) - t.a.position,
                                             recon::pn_curve_point(t.b, t.c, double(k + 1) / parts) - t.a.position);
        const double angle = recon::curved_angle(t.a.position, t.b, t.c);
        EXPECT_GE(angle, swept * (1 - 1e-6));
        EXPECT_LT(angle, swept * 1.15 + 0.02);
    }
}

TEST(PnTriangle, CurvedAngleOfFlatPointsIsThePlainAngle)
{
    const Corner a{Vec(1, 0, 0), Vec::UnitZ()}, b{Vec(0, 2, 0), Vec::UnitZ()};
    EXPECT_NEAR(recon::curved_angle<double>(Vec::Zero(), a, b), std::acos(0.0), 1e-12);
}

TEST(PnTriangle, Equation6OnConstructedCases)
{
    const auto pair = [](double normals_apart, double slope)
    {
        // Two normals at +-normals_apart/2 around z, the second point at `slope` above the plane [radians].
        const double h = normals_apart / 2;
        const Corner a{Vec::Zero(), Vec(-std::sin(h), 0, std::cos(h))};
        const Corner b{Vec(std::cos(slope), 0, std::sin(slope)), Vec(std::sin(h), 0, std::cos(h))};
        return recon::is_consistent(a, b);
    };
    EXPECT_TRUE(pair(0, 0));
    EXPECT_TRUE(pair(0, 1.5)); // parallel normals: every edge but the normal itself
    EXPECT_TRUE(pair(1.0, 0.5));
    EXPECT_FALSE(pair(1.0, 1.5));
    // |n0 + n1| = 2 cos h and 1 + n0.n1 = 2 cos^2 h: the limit lies at sin(slope) = cos h.
    const double h = 0.6;
    const double limit = std::asin(std::cos(h));
    EXPECT_TRUE(pair(2 * h, limit - 1e-9));
    EXPECT_FALSE(pair(2 * h, limit + 1e-9));
    EXPECT_FALSE(pair(3.1, 0.2)); // nearly opposite
}

// What the filter runs are the vector loops of kernels.h; these tie them to the equations above.

TEST(PnTriangle, EveryKernelMakesThePointsAndNormalsOfTheEquations)
{
    std::mt19937 random(9);
    constexpr int count = 21; // no whole number of vectors
    std::vector<recon::pn::WorkPoint> points(3 * count), made(count);
    std::vector<std::array<int, 3>> corners(count), parents(count);
    std::vector<Triangle> triangles;
    for (int k = 0; k < count; ++k)
    {
        triangles.push_back(random_triangle(random));
        const Triangle& t = triangles.back();
        int m = 0;
        for (const Corner* corner : {&t.a, &t.b, &t.c})
        {
            recon::pn::WorkPoint& p = points[std::size_t(3 * k + m)];
            p.position = corner->position;
            p.normal = corner->normal;
            p.spacing = 1;
            p.id = 1000 + 3 * k + m;
            corners[std::size_t(k)][std::size_t(m)] = 3 * k + m;
            ++m;
        }
    }
    for (const recon::pn::Kernels* kernel : recon::pn::all_kernels())
    {
        kernel->finish_children(points.data(), corners.data(), count, made.data(), parents.data());
        for (std::size_t k = 0; k < count; ++k)
        {
            const Triangle& t = triangles[k];
            const auto tangents = recon::pn_tangents(t.a, t.b, t.c);
            const Vec &a = t.a.position, &b = t.b.position, &c = t.c.position;
            EXPECT_LT((made[k].position - recon::pn_centre(a, b, c, tangents)).norm(), 1e-14) << kernel->instructions;
            EXPECT_LT((made[k].normal - recon::pn_centre_normal(a, b, c, tangents).normalized()).norm(), 1e-13)
                << kernel->instructions;
            EXPECT_EQ(parents[k], (std::array{points[3 * k].id, points[3 * k + 1].id, points[3 * k + 2].id}));
        }
    }
}

TEST(PnTriangle, EveryKernelMovesTheRingOutToTheGeodesicDistance)
{
    std::mt19937 random(10);
    std::uniform_real_distribution<double> u(-1, 1);
    constexpr int count = 12;
    constexpr double radius = 3;
    const Corner centre{Vec::Zero(), Vec(0.1, -0.2, 1).normalized()};
    std::vector<Corner> around;
    recon::pn::LocalPoints local;
    local.reserve(count);
    for (int k = 0; k < count; ++k)
    {
        const double angle = 2 * M_PI * k / count;
        const Vec position(std::cos(angle), std::sin(angle), 0.2 * u(random));
        around.push_back({position, shapes::draw_pair([&] { return 0.4 * u(random); }).homogeneous().normalized()});
        const Corner& p = around.back();
        local.x[k] = float(p.position.x());
        local.y[k] = float(p.position.y());
        local.z[k] = float(p.position.z());
        local.nx[k] = float(p.normal.x());
        local.ny[k] = float(p.normal.y());
        local.nz[k] = float(p.normal.z());
    }
    local.count = count;
    local.pad(count);
    recon::pn::Centre c{0, 0, 0, {}, {}, {}, float(1 / radius)};
    for (int d = 0; d < 3; ++d)
        c.n[d] = float(centre.normal[d]);
    recon::pn::set_tangents(c);
    for (const recon::pn::Kernels* kernel : recon::pn::all_kernels())
    {
        recon::pn::Ring ring;
        recon::pn::Fan fan;
        std::vector<std::int32_t> hits(count + 2 * recon::pn::lane_count);
        const int found = kernel->find_near(local, c, hits.data());
        kernel->make_fan(local, c, hits.data(), found, true, ring, fan);
        ASSERT_EQ(ring.count, count) << kernel->instructions;
        for (int k = 0; k < count; ++k)
        {
            const double expected = recon::geodesic_distance(centre, around[std::size_t(ring.source[k])]);
            EXPECT_NEAR(radius * std::hypot(ring.u[k], ring.v[k]), expected, 1e-4 * expected) << kernel->instructions;
        }
    }
}

} // namespace
