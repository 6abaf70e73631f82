#include "filter_pn_refine/samples/usable_samples.h"
#include "filter_pn_refine/step/initial_fans.h"
#include "filter_pn_refine/step/kernels.h"

#include "tests/shapes.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace
{

using namespace recon;
using namespace recon::pn;

/// The ring and the fan of sample i among those within `radius`; in space or on the geodesic projection.
void make_fan(const Kernels& kernel, const OrientedSamples& samples, int i, double radius, bool accurate, Ring& ring,
              Fan& fan)
{
    const int n = int(samples.points.size());
    LocalPoints local;
    local.reserve(n);
    for (int j = 0; j < n; ++j)
    {
        const Point& p = samples.points[std::size_t(j)];
        const Vector& normal = samples.normals[std::size_t(j)];
        local.x[j] = float(p.x());
        local.y[j] = float(p.y());
        local.z[j] = float(p.z());
        local.nx[j] = float(normal.x());
        local.ny[j] = float(normal.y());
        local.nz[j] = float(normal.z());
    }
    local.count = n;
    local.pad(n);
    Centre c{local.x[i], local.y[i], local.z[i], {local.nx[i], local.ny[i], local.nz[i]}, {}, {}, float(1 / radius)};
    set_tangents(c);
    std::vector<std::int32_t> hits(samples.points.size() + 2 * lane_count);
    const int found = kernel.find_near(local, c, hits.data());
    kernel.make_fan(local, c, hits.data(), found, accurate, ring, fan);
}

std::set<int> neighbours_of(const OrientedSamples& samples, int i, double radius, bool accurate,
                            const Kernels& kernel = kernels())
{
    Ring ring;
    Fan fan;
    make_fan(kernel, samples, i, radius, accurate, ring, fan);
    std::set<int> result;
    for (int k = 0; k < fan.count; ++k)
        result.insert(ring.source[fan.entry[k]]);
    return result;
}

TEST(Ring, FuzzyNeighbourhoodIsSymmetricForEqualRadii)
{
    // Symmetric up to rounding at the threshold, to which side of a line a point lies on, seen from either end, and to
    // points within the radius of one end only.
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
    EXPECT_LT(one_way, links / 50);
}

TEST(Ring, BadnessAgreesWithThePaperButForItsLimitWhereNormalsAgree)
{
    const OrientedSamples samples = shapes::torus(400, 1, 0.4, 5);
    // Equations 7 and 8 in double, with the definitions as printed; where normals agree to 0.95 weights go down to
    // -0.4.
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
            const double least = n.dot(samples.normals[std::size_t(a)]) >= 0.95 ? -0.4 : 0;
            double successor = least, predecessor = least;
            const Vector da = samples.points[std::size_t(a)] - p;
            for (int b : candidates)
            {
                if (a == b)
                    continue;
                const Vector db = samples.points[std::size_t(b)] - p;
                const double sine = db.normalized().dot((da - db).normalized());
                const double w = std::max(least, 0.5 * (sine / 0.5 + 1));
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

TEST(Ring, ANearNeighbourHidesNoneAcrossAHoleWhereNormalsAgree)
{
    // Around the origin, as beside a hole at -40 degrees: the one at 38 degrees lies behind the plane of that at 77.
    const double degrees[] = {-103, 38, 77, 132, 169}, lengths[] = {1.18, 0.97, 0.39, 0.74, 0.83};
    OrientedSamples samples;
    samples.points.push_back(Point::Zero());
    for (int k = 0; k < 5; ++k)
    {
        const double a = degrees[k] * M_PI / 180;
        samples.points.emplace_back(lengths[k] * std::cos(a), lengths[k] * std::sin(a), 0);
    }
    samples.normals.assign(6, Vector::UnitZ());
    for (const Kernels* kernel : all_kernels())
    {
        EXPECT_EQ(neighbours_of(samples, 0, 2, false, *kernel).count(2), 1u) << kernel->instructions;
        OrientedSamples bent = samples;
        bent.normals[2] = Eigen::AngleAxisd(0.43, samples.points[2].normalized()) * Vector::UnitZ();
        EXPECT_EQ(neighbours_of(bent, 0, 2, false, *kernel).count(2), 0u) << kernel->instructions;
    }
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

TEST(Ring, FansAreSortedByTheAngleInTheTangentPlane)
{
    // A centre and directions all around it, in the order of no angle; lengths differ so that all are neighbours.
    OrientedSamples star;
    star.points.emplace_back(0, 0, 0);
    for (int i = 0; i < 13; ++i)
    {
        const double a = 2 * M_PI * (5 * i % 13) / 13;
        star.points.emplace_back(std::cos(a), std::sin(a), 0);
    }
    star.normals.assign(star.points.size(), Vector::UnitZ());
    for (const Kernels* kernel : all_kernels())
    {
        Ring ring;
        Fan fan;
        make_fan(*kernel, star, 0, 1.5, false, ring, fan);
        ASSERT_EQ(fan.count, 13) << kernel->instructions;
        for (int k = 0; k < fan.count; ++k)
        {
            const int e = fan.entry[k];
            EXPECT_NEAR(fan.angle[k], std::atan2(ring.v[e], ring.u[e]), 4e-5) << kernel->instructions;
            EXPECT_LE(fan.angle[std::max(k - 1, 0)], fan.angle[k]) << kernel->instructions;
        }
    }
}

TEST(Ring, MoreNeighboursThanAVectorHoldsKeepOneInEachSector)
{
    OrientedSamples star;
    star.points.emplace_back(0, 0, 0);
    for (int i = 0; i < 60; ++i)
        star.points.emplace_back(std::cos(0.1 + 2 * M_PI * i / 60), std::sin(0.1 + 2 * M_PI * i / 60), 0);
    star.normals.assign(star.points.size(), Vector::UnitZ());
    for (const Kernels* kernel : all_kernels())
    {
        Ring ring;
        Fan fan;
        make_fan(*kernel, star, 0, 1.5, false, ring, fan);
        EXPECT_EQ(ring.count, 60) << kernel->instructions;
        ASSERT_EQ(fan.count, lane_count) << kernel->instructions;
        for (int k = 1; k < fan.count; ++k)
            EXPECT_LT(fan.angle[k] - fan.angle[k - 1], 4 * M_PI / lane_count) << kernel->instructions;
    }
}

TEST(Ring, EveryInstructionSetFindsTheSameNeighbours)
{
    const OrientedSamples samples = shapes::torus(900, 1, 0.4, 5);
    for (const bool accurate : {false, true})
        for (const double radius : {0.2, 0.35, 0.5}) // the last with several vectors in a ring
        {
            int differing = 0;
            for (int i = 0; i < 900; ++i)
            {
                const std::set<int> expected = neighbours_of(samples, i, radius, accurate, *all_kernels().front());
                for (const Kernels* kernel : all_kernels())
                    differing += neighbours_of(samples, i, radius, accurate, *kernel) != expected;
            }
            EXPECT_LE(differing, 9) << radius; // rounding at the threshold
        }
}

TEST(InitialFans, RadiusReachesTheFanAndThoseWhoseFanHoldsThePoint)
{
    const OrientedSamples samples = shapes::sphere(1500, 1, 4);
    const BlockSearch search(samples.points);
    const InitialFans fans = find_initial_fans(samples, search, find_nearest(samples.points, search, 1),
                                               std::vector<char>(1500, 0), 0.7, 1.5, 1, {});
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

TEST(InitialFans, AreTheSameWhereOnlyThoseNearAddedSamplesAreFoundAgain)
{
    const OrientedSamples input = shapes::sphere(3000, 1, 4);
    const UnitFrame frame(input.points);
    pn::UsableSamples usable;
    pn::choose_usable_samples(input, {}, frame, 0.8, 1, {}, usable);
    const auto find = [&](const pn::InitialFans* before, const std::vector<char>& is_changed)
    {
        return pn::find_initial_fans(usable.samples, *usable.search, usable.nearest, usable.is_crease, 0.8, 1.5, 1, {},
                                     before, is_changed);
    };
    const pn::InitialFans before = find(nullptr, {});
    const OrientedSamples added = shapes::sphere(20, 1, 9);
    for (std::size_t i = 0; i < added.points.size(); ++i)
    {
        usable.samples.points.push_back(frame.to_unit(added.points[i]));
        usable.samples.normals.push_back(added.normals[i]);
        usable.is_crease.push_back(0);
        usable.beside.push_back(0);
    }
    const std::vector<char> is_changed = pn::add_to_nearest(usable, 3000, 1);
    EXPECT_LT(std::count(is_changed.begin(), is_changed.end(), 1), 2500);
    const std::vector<int> index = usable.nearest.index;
    const pn::InitialFans fans = find(&before, is_changed);
    pn::update_nearest(usable, 1);
    const pn::InitialFans all = find(nullptr, {});
    EXPECT_EQ(index, usable.nearest.index);
    EXPECT_EQ(fans.member, all.member);
    EXPECT_EQ(fans.first, all.first);
    EXPECT_EQ(fans.gap_from, all.gap_from);
    EXPECT_EQ(fans.radius, all.radius);
}

} // namespace
