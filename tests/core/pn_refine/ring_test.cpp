#include "filter_pn_refine/initial_fans.h"
#include "filter_pn_refine/ring.h"

#include "tests/shapes.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace
{

using namespace recon;
using namespace recon::pn;

/// Fan of sample i among those within `radius`; in space or on the geodesic projection.
std::set<int> neighbours_of(const OrientedSamples& samples, int i, double radius, bool accurate)
{
    static LocalPoints local;
    local.clear();
    local.reserve(int(samples.points.size()));
    for (std::size_t j = 0; j < samples.points.size(); ++j)
    {
        local.x[j] = float(samples.points[j].x());
        local.y[j] = float(samples.points[j].y());
        local.z[j] = float(samples.points[j].z());
        local.nx[j] = float(samples.normals[j].x());
        local.ny[j] = float(samples.normals[j].y());
        local.nz[j] = float(samples.normals[j].z());
    }
    local.count = int(samples.points.size());
    const auto at = std::size_t(i);
    Centre c{local.x[at], local.y[at], local.z[at],      {local.nx[at], local.ny[at], local.nz[at]},
             {},          {},          float(1 / radius)};
    set_tangents(c);
    std::vector<std::uint8_t> classes(samples.points.size() + lane_count);
    std::vector<int> hits;
    classify_points(local, c, classes.data());
    for (std::size_t j = 0; j < samples.points.size(); ++j)
        if (classes[j] == 1)
            hits.push_back(int(j));
    Ring ring;
    float badness[ring_capacity];
    int fan[ring_capacity];
    fill_ring(local, c, hits.data(), int(hits.size()), ring);
    if (accurate)
    {
        project_geodesically(c, ring);
        measure_badness<true>(ring, badness);
    }
    else
        measure_badness<false>(ring, badness);
    const int size = sort_fan(ring, badness, fan);
    std::set<int> result;
    for (int k = 0; k < size; ++k)
        result.insert(ring.source[fan[k]]);
    return result;
}

TEST(Ring, FuzzyNeighbourhoodIsSymmetricForEqualRadii)
{
    // Symmetric up to rounding at the threshold and to which side of a line a point lies on, seen from either end.
    const OrientedSamples samples = shapes::sphere(600, 1, 3);
    int links = 0, one_way = 0;
    std::vector<std::set<int>> sets;
    for (int i = 0; i < 600; ++i)
        sets.push_back(neighbours_of(samples, i, 0.3, false));
    for (int i = 0; i < 600; ++i)
        for (int j : sets[std::size_t(i)])
        {
            ++links;
            one_way += sets[std::size_t(j)].count(i) == 0;
        }
    EXPECT_GT(links, 3000);
    EXPECT_LT(one_way, links / 100);
}

TEST(Ring, BadnessAgreesWithThePaperWordForWord)
{
    const OrientedSamples samples = shapes::torus(400, 1, 0.4, 5);
    // Equations 7 and 8 in double, with the definitions as printed.
    const auto literal = [&](int i, double radius)
    {
        const Point& p = samples.points[std::size_t(i)];
        const Vector& n = samples.normals[std::size_t(i)];
        std::vector<int> candidates;
        for (int j = 0; j < 400; ++j)
        {
            const Vector d = samples.points[std::size_t(j)] - p;
            const Vector& m = samples.normals[std::size_t(j)];
            if (j != i && d.norm() <= radius && std::abs((n + m).dot(d)) <= (1 + n.dot(m)) * d.norm() &&
                n.dot(m) >= 0.1)
                candidates.push_back(j);
        }
        const Vector e1 = n.unitOrthogonal(), e2 = n.cross(e1);
        std::set<int> kept;
        for (int a : candidates)
        {
            double successor = 0, predecessor = 0;
            const Vector da = samples.points[std::size_t(a)] - p;
            for (int b : candidates)
            {
                if (a == b)
                    continue;
                const Vector db = samples.points[std::size_t(b)] - p;
                const double sine = db.normalized().dot((da - db).normalized());
                const double w = std::max(0.0, 0.5 * (sine / 0.5 + 1));
                const double side = da.dot(e1) * db.dot(e2) - da.dot(e2) * db.dot(e1);
                double& most = side >= 0 ? successor : predecessor;
                most = std::max(most, w);
            }
            if (successor + predecessor <= 1)
                kept.insert(a);
        }
        return kept;
    };
    int differing = 0;
    for (int i = 0; i < 400; ++i)
        differing += literal(i, 0.35) != neighbours_of(samples, i, 0.35, false);
    EXPECT_LE(differing, 2); // rounding at the threshold
}

TEST(Ring, AccurateNeighbourhoodOfAGridPointIsItsNearest)
{
    OrientedSamples grid;
    for (int x = -3; x <= 3; ++x)
        for (int y = -3; y <= 3; ++y)
        {
            grid.points.emplace_back(x, y, 0);
            grid.normals.push_back(Vector::UnitZ());
        }
    const std::set<int> fan = neighbours_of(grid, 24, 2.5, true);
    for (int side : {17, 31, 23, 25})
        EXPECT_EQ(fan.count(side), 1u);
    for (int beyond : {10, 38, 22, 26})
        EXPECT_EQ(fan.count(beyond), 0u);
}

TEST(Ring, FastAngleIsAtan2)
{
    for (int i = 0; i < 1000; ++i)
    {
        const double a = -3.14 + 6.28 * i / 1000;
        EXPECT_NEAR(fast_angle(float(2.5 * std::cos(a)), float(2.5 * std::sin(a))), a, 4e-5);
    }
}

TEST(InitialFans, RadiusReachesTheFanAndThoseWhoseFanHoldsThePoint)
{
    const OrientedSamples samples = shapes::sphere(1500, 1, 4);
    const NeighbourSearch search(samples.points);
    const InitialFans fans = find_initial_fans(samples, search, std::vector<char>(1500, 0), 0.7, 1.5, 1, {});
    for (int i = 0; i < 1500; ++i)
        for (int m = fans.first[std::size_t(i)]; m < fans.first[std::size_t(i) + 1]; ++m)
        {
            const int j = fans.member[std::size_t(m)];
            const double d = (samples.points[std::size_t(i)] - samples.points[std::size_t(j)]).norm();
            EXPECT_GE(fans.radius[std::size_t(i)], d);
            EXPECT_GE(fans.radius[std::size_t(j)], d);
        }
    EXPECT_LT(*std::max_element(fans.radius.begin(), fans.radius.end()), 0.6);
    const auto closed = std::count_if(fans.widest_gap.begin(), fans.widest_gap.end(), [](double g) { return g < 2.6; });
    EXPECT_GT(closed, 1450);
}

} // namespace
