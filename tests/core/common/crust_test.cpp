#include <recon/crust/crust.h>
#include <recon/disjoint_sets.h>
#include <recon/labelling/ball_attraction.h>
#include <recon/labelling/crust_repair.h>
#include <recon/labelling/labelled_balls.h>
#include <recon/mesh/collapse_edges.h>
#include <recon/mesh/crust_mesh.h>
#include <recon/mesh/kept_components.h>
#include <recon/search/neighbours.h>
#include <recon/triangulation/delaunay.h>
#include <recon/triangulation/polar_balls.h>
#include <recon/triangulation/power_diagram.h>

#include "tests/checks.h"
#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <utility>

using namespace recon;

namespace
{

constexpr double pi = 3.14159265358979323846;
constexpr double major = 0.3, minor = 0.1;

Side true_side(const Point& p)
{
    return std::hypot(p.head<2>().norm() - major, p.z()) < minor ? Side::inner : Side::outer;
}

TriangleMesh extract_crust(const Triangulation& regular, const std::vector<Side>& labels)
{
    return triangulate_polygons(list_crust_polygons(regular, labels));
}

} // namespace

TEST(IntersectDiscWithPolygon, AgreesWithKnownAreas)
{
    using Polygon = std::vector<Eigen::Vector2d>;
    const Polygon square = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    EXPECT_NEAR(intersect_disc_with_polygon(5, square), 4, 1e-12) << "polygon inside the disc";
    EXPECT_NEAR(intersect_disc_with_polygon(0.5, square), pi / 4, 1e-12) << "disc inside the polygon";
    // Disc of radius sqrt(2) - e.g. 1.2 - cut by the square: area minus four circular segments.
    const double r = 1.2, half_angle = std::acos(1 / r);
    EXPECT_NEAR(intersect_disc_with_polygon(r, square), r * r * (pi - 4 * half_angle) + 4 * std::sqrt(r * r - 1),
                1e-12);
    const Polygon away = {{3, 3}, {5, 3}, {5, 5}};
    EXPECT_NEAR(intersect_disc_with_polygon(1, away), 0, 1e-12);
    const Polygon reversed(square.rbegin(), square.rend());
    EXPECT_NEAR(intersect_disc_with_polygon(5, reversed), -4, 1e-12);
    // Against sampling, for a triangle that contains the centre only partly.
    const Polygon triangle = {{-0.2, -0.9}, {1.4, 0.1}, {-0.5, 0.8}};
    std::mt19937 random(1);
    const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); };
    int hits = 0;
    const int trials = 400'000;
    for (int i = 0; i < trials; ++i)
    {
        const Eigen::Vector2d p = shapes::draw_pair([&] { return random() / 2147483648.0 - 1; });
        bool inside = p.norm() < 1;
        for (int k = 0; k < 3; ++k)
            inside &= cross(triangle[(k + 1) % 3] - triangle[k], p - triangle[k]) > 0;
        hits += inside;
    }
    EXPECT_NEAR(intersect_disc_with_polygon(1, triangle), 4.0 * hits / trials, 0.01);
}

TEST(LabelPolarBalls, SharesBallsOnlyWhereTheSamplesAgree)
{
    BallLabellingOptions sharing;
    sharing.sharing = BallSharing::undisputed;
    const auto count_balls =
        [&](const Points& samples, const BallLabellingOptions& options, int genus, const Vectors& normals = {})
    {
        PhaseTimes times;
        const LabelledBalls labelled = label_polar_balls(samples, normals, options, times);
        const checks::MeshReport report = checks::examine_mesh(extract_crust(labelled.regular, labelled.labels));
        EXPECT_EQ(report.components, 1) << report.text();
        EXPECT_EQ(report.genus(), genus) << report.text();
        return double(labelled.kept.balls.size());
    };
    const auto [torus, normals] = shapes::torus(4000, major, minor, 1);
    EXPECT_LT(count_balls(torus, sharing, 1), 0.5 * count_balls(torus, {}, 1));
    EXPECT_LT(count_balls(torus, sharing, 1, normals), 0.5 * count_balls(torus, {}, 1, normals));
    // Box: at its edges the votes are violated.
    const Points box = shapes::box(1500, Vector(0.7, 0.5, 0.4), 1).points;
    EXPECT_EQ(count_balls(box, sharing, 0), count_balls(box, {}, 0));
    BallLabellingOptions always;
    always.sharing = BallSharing::always;
    EXPECT_LT(count_balls(box, always, 0), 0.8 * count_balls(box, {}, 0));
}

// What the outside floods it floods through all balls as well: these are not tried.
TEST(LabelPolarBalls, SharesBallsOfFloodedSamples)
{
    PhaseTimes times;
    const Points terrain = shapes::sheet(3000, shapes::wavy_terrain(0.1, 4, 4), 1).points;
    BallLabellingOptions options;
    const LabelledBalls all = label_polar_balls(terrain, {}, options, times);
    options.sharing = BallSharing::undisputed;
    const LabelledBalls shared = label_polar_balls(terrain, {}, options, times);
    EXPECT_GT(all.violated_votes, flooded_above);
    EXPECT_FALSE(all.is_shared);
    EXPECT_GT(shared.violated_votes, flooded_above);
    EXPECT_TRUE(shared.is_shared);
    EXPECT_LT(double(shared.kept.balls.size()), 0.8 * double(all.kept.balls.size()));
}

TEST(SpareBridges, LeavesOneChainWhereAllOfANeckIsDoubtful)
{
    PhaseTimes times;
    const LabelledBalls labelled = label_polar_balls(shapes::capsule(3000, 0.15, 0.35, 1).points, {}, {}, times);
    std::vector<int> doubtful;
    std::vector<double> margins(labelled.labels.size(), 1);
    for (int i = 0; i < int(labelled.labels.size()); ++i)
    {
        const Point& centre = labelled.kept.balls[i].centre;
        margins[i] = std::hypot(centre.x(), centre.y()) < 0.01 ? 0.5 : 0.1;
        if (labelled.labels[i] == Side::inner && std::abs(centre.z()) < 0.1)
            doubtful.push_back(i);
    }
    ASSERT_GT(doubtful.size(), 20u);
    std::vector<int> dropped = doubtful;
    spare_bridges(labelled.regular, labelled.labels, margins, 0.02, dropped);
    EXPECT_LT(dropped.size(), doubtful.size());
    EXPECT_GT(2 * dropped.size(), doubtful.size());
    for (const int i : doubtful)
        if (!std::binary_search(dropped.begin(), dropped.end(), i))
        {
            EXPECT_EQ(margins[i], 0.5) << "weaker chains than need be";
        }
    // What stays holds both ends together.
    std::vector<char> stays(labelled.labels.size());
    for (std::size_t i = 0; i < stays.size(); ++i)
        stays[i] = labelled.labels[i] == Side::inner && !std::binary_search(dropped.begin(), dropped.end(), int(i));
    DisjointSets parts(stays.size());
    for (const auto& cell : labelled.regular.cells)
        for (const int a : cell.vertices)
            for (const int b : cell.vertices)
                if (a >= 0 && b >= 0 && stays[a] && stays[b])
                    parts.join(a, b);
    std::map<int, int> size;
    for (int i = 0; i < int(stays.size()); ++i)
        if (stays[i])
            ++size[parts.find(i)];
    int large = 0;
    for (const auto& part : size)
        large += part.second > 20;
    EXPECT_EQ(large, 1);
}

TEST(LabelPolarBalls, KeepCoarsePartsBesideFineOnes)
{
    // Two coarse spheres beside a fine one: outer balls touch both kinds.
    Points samples;
    const auto append = [&](int n, double radius, const Point& centre)
    {
        for (const Point& p : shapes::sphere(n, radius, std::uint64_t(n)).points)
            samples.push_back(p + centre);
    };
    append(120, 0.2, Point(-0.25, 0, 0));
    append(6000, 0.04, Point(0, 0, 0));
    append(130, 0.2, Point(0.25, 0, 0));
    PhaseTimes times;
    const LabelledBalls labelled = label_polar_balls(samples, {}, {}, times);
    const checks::MeshReport report = checks::examine_mesh(extract_crust(labelled.regular, labelled.labels));
    EXPECT_EQ(report.components, 3) << report.text();
    EXPECT_NEAR(report.volume, 4.0 / 3 * pi * (2 * 0.008 + 0.000064), 0.1 * 0.067);
}

TEST(LabelPolarBalls, TellsInnerFromOuterBallsOfATorus)
{
    for (const bool with_normals : {false, true})
    {
        const OrientedSamples torus = shapes::torus(4000, major, minor, 1);
        PhaseTimes times;
        const LabelledBalls labelled =
            label_polar_balls(torus.points, with_normals ? torus.normals : Vectors{}, {}, times);
        int wrong = 0;
        for (std::size_t i = 0; i < labelled.labels.size(); ++i)
            wrong += labelled.labels[i] != true_side(labelled.kept.balls[i].centre);
        EXPECT_LT(wrong, 0.002 * double(labelled.labels.size()));
        EXPECT_LT(labelled.violated_votes, 0.01);
    }
}

TEST(LabelPolarBalls, ThinToriKeepTheirHolesWhereThereWasLittleNoise)
{
    for (const int n : {150, 200, 300, 400})
    {
        const OrientedSamples torus = shapes::torus(n, 0.35, 0.12, 3);
        BallLabellingOptions options;
        options.noise_taken = 0.0002;
        PhaseTimes times;
        const LabelledBalls labelled = label_polar_balls(torus.points, torus.normals, options, times);
        EXPECT_EQ(checks::examine_mesh(extract_crust(labelled.regular, labelled.labels)).genus(), 1) << n;
    }
}

TEST(LabelPolarBalls, OneBallStandsForThoseThatAreAlike)
{
    // The balls of an exact torus lie on a circle and on its axis, each of the one kind beside all of the other.
    PhaseTimes times;
    const LabelledBalls torus = label_polar_balls(shapes::torus(8000, major, minor, 1).points, {}, {}, times);
    const std::vector<char> is_visible = mark_vertices(torus.regular, int(torus.labels.size()));
    EXPECT_LT(std::count(is_visible.begin(), is_visible.end(), 1), 0.7 * double(is_visible.size()));
    for (const auto& [hidden, stands_for_it] : torus.twins)
    {
        EXPECT_FALSE(is_visible[hidden]);
        EXPECT_EQ(torus.labels[hidden], torus.labels[stands_for_it]);
    }
    const TriangleMesh crust = extract_crust(torus.regular, torus.labels);
    EXPECT_EQ(measure_closed_topology(crust).genus(), 1);
    for (const Point& p : crust.vertices)
        EXPECT_LT(shapes::distance_to_torus(p, major, minor), 0.02 * minor);
}

TEST(ExtractCrust, IsAClosedOrientedManifoldForAnyLabels)
{
    // Even labels that mean nothing give a manifold: it is one by construction.
    std::mt19937 random(3);
    Points samples = shapes::torus(1500, major, minor, 2).points;
    append_box_corners(samples);
    const Triangulation delaunay = triangulate_delaunay(samples);
    const PolarBalls kept = keep_polar_balls(delaunay, samples, find_poles(delaunay, samples),
                                             [](double r, const auto&) { return r > 0.02; });
    PowerDiagram diagram(kept.balls);
    const Triangulation regular = diagram.triangulation();
    for (int trial = 0; trial < 5; ++trial)
    {
        std::vector<Side> labels;
        for (const Ball& ball : kept.balls)
            labels.push_back(trial == 0 ? true_side(ball.centre) : random() % 2 ? Side::inner : Side::outer);
        for (std::size_t c = std::size_t(regular.finite_cells); c < regular.cells.size(); ++c)
            for (const int v : regular.cells[c].vertices)
                if (v >= 0)
                    labels[v] = Side::outer;
        const TriangleMesh mesh = extract_crust(regular, labels);
        const checks::MeshReport report = checks::examine_mesh(mesh);
        EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
        EXPECT_EQ(report.unreferenced_vertices, 0);
        EXPECT_GT(report.volume, 0);
        const Topology topology = measure_topology(mesh);
        EXPECT_EQ(report.euler_characteristic, topology.euler_characteristic);
        EXPECT_EQ(report.components, topology.components);
        EXPECT_EQ(topology.boundary_loops, 0);
        EXPECT_EQ(measure_closed_topology(mesh).euler_characteristic, report.euler_characteristic);
        EXPECT_EQ(mesh.faux_edges.size(), mesh.triangles.size());
        if (trial == 0)
        {
            EXPECT_EQ(report.genus(), 1);
            EXPECT_NEAR(report.volume, 2 * pi * pi * major * minor * minor, 0.02 * report.volume);
        }
    }
}

TEST(CollapseShortEdges, KeepsTheTopologyAndTheShapeForAnyNumberOfThreads)
{
    // Enough vertices for several of the blocks that go side by side.
    Points samples = shapes::with_noise(shapes::torus(8000, major, minor, 2).points, 1e-4, 3);
    append_box_corners(samples);
    const Triangulation delaunay = triangulate_delaunay(samples);
    const PolarBalls kept = keep_polar_balls(delaunay, samples, find_poles(delaunay, samples),
                                             [](double r, const auto&) { return r > 0.02; });
    std::vector<Side> labels;
    for (const Ball& ball : kept.balls)
        labels.push_back(true_side(ball.centre));
    const TriangleMesh crust = extract_crust(PowerDiagram(kept.balls).triangulation(), labels);
    ASSERT_GT(crust.vertices.size(), 60000u);
    const std::vector<double> scale(crust.vertices.size(), 0.015);
    const std::vector<int> merged(crust.vertices.size(), 1);
    EdgeCollapseOptions options;
    options.target_vertices = 8000;
    TriangleMesh alone;
    for (options.threads = 1; options.threads <= 3; ++options.threads)
    {
        TriangleMesh mesh = crust;
        const std::vector<int> former =
            collapse_short_edges(mesh, pair_half_edges(mesh, options.threads), scale, merged, options);
        const checks::MeshReport report = checks::examine_mesh(mesh);
        EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
        EXPECT_EQ(report.genus(), 1);
        EXPECT_NEAR(report.volume, 2 * pi * pi * major * minor * minor, 0.02 * report.volume);
        EXPECT_EQ(former.size(), mesh.vertices.size());
        EXPECT_LE(mesh.vertices.size(), 9000u);
        EXPECT_GE(mesh.vertices.size(), 4000u);
        if (options.threads == 1)
            alone = mesh;
        EXPECT_EQ(mesh.triangles, alone.triangles);
        EXPECT_EQ(mesh.vertices, alone.vertices);
    }
}

TEST(DropComponents, LargestKeepsTheOneThatEnclosesMost)
{
    const std::vector<std::array<int, 3>> faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    TriangleMesh mesh;
    for (const double size : {1.0, 3.0, 2.0})
    {
        const int base = int(mesh.vertices.size());
        for (const Point& p : {Point(0, 0, 0), Point(1, 0, 0), Point(0, 1, 0), Point(0, 0, 1)})
            mesh.vertices.push_back(size * p + Point(5 * base, 0, 0));
        for (const auto& f : faces)
            mesh.triangles.push_back({f[0] + base, f[1] + base, f[2] + base});
    }
    const DroppedBodies dropped = drop_components(mesh, KeepComponents::largest, 1);
    EXPECT_EQ(dropped.count, 2);
    EXPECT_NEAR(dropped.volume, (8.0 + 1) / 27, 1e-9);
    EXPECT_EQ(mesh.vertices.size(), 4u);
    EXPECT_NEAR(checks::examine_mesh(mesh).volume, 27.0 / 6, 1e-9);
}

// Not its size tells whether a body is stray, but how many samples it holds.
TEST(DropComponents, AutomaticKeepsWhatHoldsATwentiethOfTheTriangles)
{
    const auto append_bipyramid = [](TriangleMesh& mesh, int sides, double x)
    {
        const int base = int(mesh.vertices.size());
        mesh.vertices.push_back(Point(x, 0, -1));
        mesh.vertices.push_back(Point(x, 0, 1));
        for (int k = 0; k < sides; ++k)
        {
            const double angle = 2 * std::acos(-1.0) * k / sides;
            mesh.vertices.push_back(Point(x + std::cos(angle), std::sin(angle), 0));
            const int here = base + 2 + k, next = base + 2 + (k + 1) % sides;
            mesh.triangles.push_back({base, next, here});
            mesh.triangles.push_back({base + 1, here, next});
        }
    };
    for (const auto& [sides, kept] : {std::pair{9, 1}, std::pair{10, 2}})
    {
        TriangleMesh mesh;
        append_bipyramid(mesh, 200, 0);
        append_bipyramid(mesh, sides, 4);
        const DroppedBodies dropped = drop_components(mesh, KeepComponents::automatic, 1);
        EXPECT_EQ(find_components(mesh).count, kept);
        EXPECT_EQ(dropped.count, 2 - kept);
    }
}

// Small bodies that many points lie on are missed, a stray shell is not.
TEST(DropComponents, IsWorthAWordWhereBodiesHoldAFiftiethOfTheTriangles)
{
    const std::vector<std::array<int, 3>> faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    const auto append_tetrahedra = [&](TriangleMesh& mesh, int count, double size, double x)
    {
        // Upon one another, as one component.
        const int base = int(mesh.vertices.size());
        for (const Point& p : {Point(0, 0, 0), Point(1, 0, 0), Point(0, 1, 0), Point(0, 0, 1)})
            mesh.vertices.push_back(size * p + Point(x, 0, 0));
        for (int k = 0; k < count; ++k)
            for (const auto& f : faces)
                mesh.triangles.push_back({f[0] + base, f[1] + base, f[2] + base});
    };
    for (const auto& bodies : {std::vector{1}, std::vector{3}, std::vector{1, 1, 1}})
    {
        TriangleMesh mesh;
        append_tetrahedra(mesh, 100, 1, 0);
        int all = 0;
        for (const int inside : bodies)
        {
            append_tetrahedra(mesh, inside, 0.1, 4 + all);
            all += inside;
        }
        const DroppedBodies dropped = drop_components(mesh, KeepComponents::automatic, 1);
        EXPECT_EQ(find_components(mesh).count, 1);
        EXPECT_EQ(dropped.count, int(bodies.size()));
        EXPECT_NEAR(dropped.samples, all / (100.0 + all), 1e-9);
        EXPECT_EQ(describe(dropped).empty(), all == 1);
    }
}

// Readings of what is far from a scanner are as far apart.
TEST(DropComponents, AutomaticKeepsThinBodiesAsDenseAsTheRestSeenFromTheScanner)
{
    // A box of so many steps along its sides.
    const auto append_slab = [](TriangleMesh& mesh, int steps, double step, double thickness, double x)
    {
        const int base = int(mesh.vertices.size()), row = steps + 1;
        const auto front = [&](int i, int j) { return base + 2 * (i * row + j); };
        const auto append = [&](int a, int b, int c, int d)
        {
            mesh.triangles.push_back({a, b, c});
            mesh.triangles.push_back({a, c, d});
        };
        for (int i = 0; i <= steps; ++i)
            for (int j = 0; j <= steps; ++j)
                for (const double depth : {0.0, thickness})
                    mesh.vertices.push_back(Point(x + depth, step * (i - steps / 2.0), step * (j - steps / 2.0)));
        for (int i = 0; i < steps; ++i)
        {
            for (int j = 0; j < steps; ++j)
            {
                append(front(i, j), front(i, j + 1), front(i + 1, j + 1), front(i + 1, j));
                append(front(i, j) + 1, front(i + 1, j) + 1, front(i + 1, j + 1) + 1, front(i, j + 1) + 1);
            }
            append(front(i, 0), front(i + 1, 0), front(i + 1, 0) + 1, front(i, 0) + 1);
            append(front(i + 1, steps), front(i, steps), front(i, steps) + 1, front(i + 1, steps) + 1);
            append(front(0, i + 1), front(0, i), front(0, i) + 1, front(0, i + 1) + 1);
            append(front(steps, i), front(steps, i + 1), front(steps, i + 1) + 1, front(steps, i) + 1);
        }
    };
    TriangleMesh both;
    append_slab(both, 60, 1, 5, 60);
    append_slab(both, 8, 5, 6, 300);
    ASSERT_GT(measure_volume(both), 0);
    ASSERT_EQ(checks::examine_mesh(both).components, 2);
    const auto count_kept = [&](const std::function<Viewpoints()>& find_viewpoints)
    {
        TriangleMesh mesh = both;
        drop_components(mesh, KeepComponents::automatic, 1, find_viewpoints);
        return find_components(mesh).count;
    };
    EXPECT_EQ(count_kept({}), 1);
    EXPECT_EQ(count_kept([] { return Viewpoints(); }), 1);
    EXPECT_EQ(count_kept([] { return Viewpoints(Point::Zero()); }), 2);
    EXPECT_EQ(count_kept([] { return Viewpoints(Point(250, 0, 0)); }), 1);
}

TEST(CrustRepair, AbsorbsIslandsAndCutsAPlantedHandle)
{
    Points samples = shapes::sphere(3000, 0.4, 1).points;
    append_box_corners(samples);
    const Triangulation delaunay = triangulate_delaunay(shapes::with_noise(samples, 1e-3, 1));
    // Balls of a grid, the inside of a sphere labelled inner: a diagram in which faults can be planted at will.
    std::vector<Ball> balls;
    std::vector<Side> labels;
    const int steps = 14;
    std::mt19937 random(1);
    for (int x = 0; x <= steps; ++x)
        for (int y = 0; y <= steps; ++y)
            for (int z = 0; z <= steps; ++z)
            {
                Point p = (Point(x, y, z) / steps - Point::Constant(0.5)) * 1.2;
                for (int k = 0; k < 3; ++k)
                    p[k] += 1e-3 * (random() / 4294967296.0);
                balls.push_back({p, 0.05});
                labels.push_back(p.norm() < 0.4 ? Side::inner : Side::outer);
            }
    PowerDiagram diagram(balls);
    const Triangulation regular = diagram.triangulation();
    std::vector<char> is_root(balls.size(), 0), is_small(balls.size(), 1);
    for (std::size_t c = std::size_t(regular.finite_cells); c < regular.cells.size(); ++c)
        for (const int v : regular.cells[c].vertices)
            if (v >= 0)
                is_root[v] = 1;
    const std::vector<Side> truth = labels;
    const auto index = [&](int x, int y, int z) { return (x * (steps + 1) + y) * (steps + 1) + z; };

    std::vector<int> weight(balls.size(), 1);
    std::vector<char> is_large(balls.size(), 0);
    labels[index(7, 7, 7)] = Side::outer;  // a void
    labels[index(1, 1, 13)] = Side::inner; // an island
    EXPECT_EQ(absorb_islands(regular, is_root, weight, is_large, 0.02, labels), 2);
    EXPECT_EQ(labels, truth);
    weight[index(7, 7, 7)] = 1000; // a void whose balls coincide
    labels[index(7, 7, 7)] = Side::outer;
    EXPECT_EQ(absorb_islands(regular, is_root, weight, is_large, 0.02, labels), 0);
    labels = truth;
    // A body of few balls, one of them large; small ones alone are noise.
    weight[index(1, 1, 13)] = 30;
    for (const bool has_large : {true, false})
    {
        is_large[index(1, 1, 13)] = has_large;
        labels[index(1, 1, 13)] = Side::inner;
        EXPECT_EQ(absorb_islands(regular, is_root, weight, is_large, 0.1, labels), has_large ? 0 : 1);
    }
    EXPECT_EQ(labels, truth);

    // A tunnel of outer balls through the middle makes a torus; all but one of them are certain, so that one is cut.
    std::vector<double> margins(balls.size(), 1);
    for (int z = 0; z <= steps; ++z)
        labels[index(7, 7, z)] = Side::outer;
    ASSERT_EQ(checks::examine_mesh(extract_crust(regular, labels)).genus(), 1);
    EXPECT_EQ(cut_handles(regular, is_root, is_small, margins, labels), 0) << "certain balls stay";
    margins[index(7, 7, 7)] = 0.2;
    EXPECT_EQ(cut_handles(regular, is_root, is_small, margins, labels), 1);
    EXPECT_EQ(checks::examine_mesh(extract_crust(regular, labels)).genus(), 0);
}

TEST(DisjointSets, AreRepresentedByTheirLowestMember)
{
    DisjointSets sets(6);
    EXPECT_TRUE(sets.join(5, 3));
    EXPECT_TRUE(sets.join(4, 2));
    EXPECT_TRUE(sets.join(3, 4));
    EXPECT_FALSE(sets.join(2, 5));
    EXPECT_EQ(sets.find(5), 2);
    EXPECT_EQ(sets.find(0), 0);
    EXPECT_EQ(sets.find(1), 1);
}
