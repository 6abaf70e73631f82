#include <recon/labelling/opposite_votes.h>
#include <recon/search/block_search.h>
#include <recon/triangulation/delaunay.h>
#include <recon/triangulation/polar_balls.h>

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

using namespace recon;

namespace
{

constexpr double pi = 3.14159265358979323846;
constexpr double major = 0.3, minor = 0.1;

} // namespace

TEST(FindPoles, ReachTheMedialAxisOfATorus)
{
    Points samples = shapes::torus(4000, major, minor, 1).points;
    const OrientedSamples oriented = shapes::torus(4000, major, minor, 1);
    append_box_corners(samples);
    const Triangulation delaunay = triangulate_delaunay(samples);
    const Poles poles = find_poles(delaunay, samples),
                along = find_poles_along_normals(delaunay, samples, oriented.normals);
    int inner_right = 0, same = 0;
    for (int v = 0; v < 4000; ++v)
    {
        ASSERT_NE(poles.cells[v][0], Poles::none);
        ASSERT_NE(poles.cells[v][1], Poles::none);
        const Vector first = delaunay.centres[poles.cells[v][0]] - samples[v];
        const Vector second = delaunay.centres[poles.cells[v][1]] - samples[v];
        EXPECT_LT(first.dot(second), 0);
        EXPECT_GE(first.norm(), second.norm());
        // The inner medial axis is the circle of radius `major`.
        const Point inner = delaunay.centres[along.cells[v][1]];
        inner_right += std::hypot(inner.head<2>().norm() - major, inner.z()) < 0.15 * minor;
        same += (poles.cells[v][0] == along.cells[v][0] && poles.cells[v][1] == along.cells[v][1]) ||
                (poles.cells[v][0] == along.cells[v][1] && poles.cells[v][1] == along.cells[v][0]);
    }
    EXPECT_GT(inner_right, 3960);
    EXPECT_GT(same, 3960);
}

TEST(FindPoles, AreTheSameForAnyNumberOfThreads)
{
    const OrientedSamples oriented = shapes::box(500, Vector(0.7, 0.5, 0.4), 1); // with slant poles
    Points samples = oriented.points;
    append_box_corners(samples);
    const Triangulation delaunay = triangulate_delaunay(samples);
    Poles one = find_poles(delaunay, samples), three = find_poles(delaunay, samples, 3);
    EXPECT_EQ(one.cells, three.cells);
    EXPECT_EQ(find_poles_along_normals(delaunay, samples, oriented.normals).cells,
              find_poles_along_normals(delaunay, samples, oriented.normals, 3).cells);
    find_slant_poles(delaunay, samples, one);
    find_slant_poles(delaunay, samples, three, 3);
    EXPECT_EQ(one.slant, three.slant);
    EXPECT_NE(one.slant, decltype(one.slant)(samples.size(), {Poles::none, Poles::none}));
}

TEST(FindSlantPoles, FillTheGapsBetweenRingsAndAreNotNeededElsewhere)
{
    // A limb of radius 1 sampled in rings; from both its sides every second gap is the smaller one.
    constexpr int rings = 12, around = 16;
    const auto height = [](int ring) { return 1.9 * ring + (ring % 2 ? 0.3 : 0); };
    std::mt19937 random(5);
    std::uniform_real_distribution<double> jitter(-0.005, 0.005);
    Points limb;
    for (int ring = 0; ring < rings; ++ring)
        for (int k = 0; k < around; ++k)
        {
            const double angle = 2 * pi * (k + 0.5 * (ring % 2)) / around;
            limb.emplace_back(std::cos(angle) + jitter(random), std::sin(angle) + jitter(random),
                              height(ring) + jitter(random));
        }
    const UnitFrame frame(limb);
    limb = frame.to_unit(limb);
    append_box_corners(limb);
    const Triangulation delaunay = triangulate_delaunay(limb);
    const auto count_filled = [&](const Poles& poles)
    {
        const PolarBalls kept = keep_polar_balls(delaunay, limb, poles, [](double, const auto&) { return true; });
        int filled = 0;
        for (int gap = 0; gap + 1 < rings; ++gap)
        {
            bool has_ball = false;
            for (const Ball& ball : kept.balls)
            {
                const Point centre = frame.from_unit(ball.centre);
                has_ball |=
                    centre.head<2>().norm() < 0.3 && std::abs(2 * centre.z() - height(gap) - height(gap + 1)) < 0.6;
            }
            filled += has_ball;
        }
        return filled;
    };
    Poles poles = find_poles(delaunay, limb);
    EXPECT_LT(count_filled(poles), rings - 1);
    find_slant_poles(delaunay, limb, poles);
    EXPECT_EQ(count_filled(poles), rings - 1);

    Points dense = shapes::torus(4000, major, minor, 1).points;
    append_box_corners(dense);
    const Triangulation slender = triangulate_delaunay(dense);
    poles = find_poles(slender, dense);
    find_slant_poles(slender, dense, poles);
    int slant = 0;
    for (const auto& cells : poles.slant)
        slant += (cells[0] != Poles::none) + (cells[1] != Poles::none);
    EXPECT_LT(slant, 40);
}

TEST(SharePoles, LeavesFewerBallsThatTouchEverySampleOnBothSides)
{
    constexpr int n = 4000;
    Points samples = shapes::torus(n, major, minor, 1).points;
    append_box_corners(samples);
    const Triangulation delaunay = triangulate_delaunay(samples);
    const Poles own = find_poles(delaunay, samples);
    Poles shared = own;
    share_poles(delaunay, samples, shared);
    std::set<int> before, after;
    for (int v = 0; v < n; ++v)
        for (int side = 0; side < 2; ++side)
        {
            const int c = shared.cells[v][side];
            ASSERT_NE(c, Poles::none);
            before.insert(own.cells[v][side]);
            after.insert(c);
            const Vector pole = delaunay.centres[own.cells[v][side]] - samples[v],
                         offset = delaunay.centres[c] - samples[v];
            EXPECT_GT(offset.dot(pole), 0.94 * offset.norm() * pole.norm());
            EXPECT_GE(offset.norm(), 0.69 * pole.norm());
            EXPECT_EQ(std::count(delaunay.cells[c].vertices.begin(), delaunay.cells[c].vertices.end(), v), 1);
        }
    EXPECT_LT(after.size(), 0.5 * double(before.size()));
    Poles on_three = own;
    share_poles(delaunay, samples, on_three, 3);
    EXPECT_EQ(on_three.cells, shared.cells);
    for (std::size_t v = n; v < samples.size(); ++v) // corners of the box
        EXPECT_EQ(shared.cells[v], own.cells[v]);
}

TEST(PolarBalls, OutwardnessTellsTheirSide)
{
    const OrientedSamples sphere = shapes::sphere(2000, 0.4, 1);
    Points samples = sphere.points;
    append_box_corners(samples);
    const Triangulation delaunay = triangulate_delaunay(samples);
    const PolarBalls kept =
        keep_polar_balls(delaunay, samples, find_poles(delaunay, samples), [](double, const auto&) { return true; });
    int outer = 0;
    for (int b = 0; b < int(kept.balls.size()); ++b)
    {
        const double outwardness = measure_outwardness(kept, b, samples, sphere.normals);
        const bool is_outer = kept.balls[b].centre.norm() > 0.4;
        const bool is_at_corners =
            std::all_of(kept.touched[b].begin(), kept.touched[b].end(), [](int v) { return v >= 2000; });
        outer += is_outer;
        EXPECT_TRUE(is_at_corners ? outwardness == 0 : is_outer ? outwardness > 0.7 : outwardness < -0.7);
        EXPECT_EQ(measure_outwardness(kept, b, samples, {}), 0);
    }
    EXPECT_GT(outer, 500);
}

TEST(OppositeVotes, CrossASlabOfNoise)
{
    // Noise far above the spacing: no sample keeps both balls, yet votes go across.
    Points samples = shapes::with_noise(shapes::sphere(6000, 0.4, 1).points, 0.02, 2);
    const Points free_samples = samples;
    const BlockSearch search(free_samples);
    append_box_corners(samples);
    const Triangulation delaunay = triangulate_delaunay(samples);
    const PolarBalls kept = keep_polar_balls(delaunay, samples, find_poles(delaunay, samples),
                                             [](double r, const auto&) { return r > 0.06; });
    const std::vector<SignedEdge> votes = list_opposite_votes(samples, kept, search, 1);
    const std::vector<SignedEdge> same = list_opposite_votes(samples, kept, search, 3);
    ASSERT_EQ(votes.size(), same.size());
    double right = 0, total = 0;
    for (std::size_t i = 0; i < votes.size(); ++i)
    {
        EXPECT_EQ(votes[i].weight, same[i].weight);
        EXPECT_LE(votes[i].weight, 0);
        total -= votes[i].weight;
        const auto inside = [&](int ball) { return kept.balls[ball].centre.norm() < 0.4; };
        right -= inside(votes[i].a) != inside(votes[i].b) ? votes[i].weight : 0;
    }
    EXPECT_GT(total, 3000);
    EXPECT_GT(right, 0.99 * total);
}
