#include <recon/crust/crust.h>
#include <recon/labelling/labelled_balls.h>
#include <recon/mesh/collapse_edges.h>
#include <recon/mesh/flip_edges.h>
#include <recon/mesh/half_edge_mesh.h>
#include <recon/mesh/interpolate_samples.h>
#include <recon/mesh/weld_clusters.h>
#include <recon/search/nearest_samples.h>

#include <gtest/gtest.h>

#include <tests/checks.h>
#include <tests/shapes.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

using namespace recon;

namespace
{

/// Crust of clean samples, through them if asked.
TriangleMesh crust_of(const Points& samples, bool through, int threads = 1, BallSharing sharing = BallSharing::none)
{
    PhaseTimes times;
    BallLabellingOptions labelling;
    labelling.sharing = sharing;
    CrustOptions options;
    options.target_vertices = int(samples.size());
    options.threads = threads;
    options.interpolated = through ? &samples : nullptr;
    return make_crust(label_polar_balls(samples, {}, labelling, times), options);
}

int count_samples_among(const Points& vertices, const Points& samples)
{
    const auto is_less = [](const Point& p, const Point& q)
    { return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3); };
    Points sorted = vertices;
    std::sort(sorted.begin(), sorted.end(), is_less);
    return int(std::count_if(samples.begin(), samples.end(),
                             [&](const Point& p)
                             { return std::binary_search(sorted.begin(), sorted.end(), p, is_less); }));
}

/// Grid of (steps + 1) x (steps + 1) vertices over a unit square with height(x, y), closed by a bottom at -1; all
/// diagonals run the same way.
template <class Height>
TriangleMesh block_with_top(int steps, Height&& height)
{
    TriangleMesh mesh;
    const auto vertex = [&](int x, int y, int level)
    { return level * (steps + 1) * (steps + 1) + y * (steps + 1) + x; };
    for (const int level : {0, 1})
        for (int y = 0; y <= steps; ++y)
            for (int x = 0; x <= steps; ++x)
            {
                const double u = double(x) / steps, v = double(y) / steps;
                mesh.vertices.emplace_back(u, v, level == 0 ? -1 : height(u, v));
            }
    const auto add = [&](int a, int b, int c, int d)
    {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
    };
    for (int k = 0; k < steps; ++k)
    {
        for (int j = 0; j < steps; ++j)
        {
            add(vertex(j, k, 1), vertex(j + 1, k, 1), vertex(j + 1, k + 1, 1), vertex(j, k + 1, 1));
            add(vertex(j, k, 0), vertex(j, k + 1, 0), vertex(j + 1, k + 1, 0), vertex(j + 1, k, 0));
        }
        add(vertex(k, 0, 0), vertex(k + 1, 0, 0), vertex(k + 1, 0, 1), vertex(k, 0, 1));
        add(vertex(k + 1, steps, 0), vertex(k, steps, 0), vertex(k, steps, 1), vertex(k + 1, steps, 1));
        add(vertex(0, k + 1, 0), vertex(0, k, 0), vertex(0, k, 1), vertex(0, k + 1, 1));
        add(vertex(steps, k, 0), vertex(steps, k + 1, 0), vertex(steps, k + 1, 1), vertex(steps, k, 1));
    }
    return mesh;
}

TEST(InterpolateSamples, ACrustOfCleanSamplesHasThemAsVertices)
{
    const Points samples = shapes::torus(4000, 0.35, 0.12, 1).points;
    const TriangleMesh mesh = crust_of(samples, true), plain = crust_of(samples, false);
    const checks::MeshReport report = checks::examine_mesh(mesh);
    EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.genus(), 1);
    EXPECT_GE(count_samples_among(mesh.vertices, samples), 3998);
    EXPECT_LE(mesh.vertices.size(), 4001u);
    EXPECT_LT(count_samples_among(plain.vertices, samples), 3000);
}

// The corner nearest to a sample can lie half an edge beside it, though the surface passes close by.
TEST(InterpolateSamples, MovesVerticesFarAlongTheSurface)
{
    for (const Points& samples : {shapes::sphere(8000, 0.4, 3).points, shapes::torus(8000, 0.35, 0.12, 3).points})
    {
        const TriangleMesh mesh = crust_of(samples, true, 1, BallSharing::undisputed);
        EXPECT_TRUE(checks::examine_mesh(mesh).is_closed_oriented_manifold());
        EXPECT_GE(count_samples_among(mesh.vertices, samples), 7992); // 7948 and 7978 if as far from the corner alone
    }
}

TEST(InterpolateSamples, CreasesBecomeEdges)
{
    const Vector sides(0.6, 0.5, 0.4);
    Points samples = shapes::box(5000, sides, 1).points;
    // On the edges too, as scans of sharp models have them.
    for (int axis = 0; axis < 3; ++axis)
        for (int edge = 0; edge < 4; ++edge)
            for (int k = 0; k <= 40; ++k)
            {
                Point p;
                p[axis] = (k / 40.0 - 0.5) * sides[axis];
                p[(axis + 1) % 3] = (edge & 1 ? 0.5 : -0.5) * sides[(axis + 1) % 3];
                p[(axis + 2) % 3] = (edge & 2 ? 0.5 : -0.5) * sides[(axis + 2) % 3];
                if (axis == 0 || (k > 0 && k < 40)) // corners once
                    samples.push_back(p);
            }
    const auto missing_volume = [&](bool through)
    {
        const checks::MeshReport report = checks::examine_mesh(crust_of(samples, through));
        EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
        EXPECT_EQ(report.genus(), 0);
        return std::abs(1 - report.volume / sides.prod());
    };
    EXPECT_LT(missing_volume(true), 0.2 * missing_volume(false));
}

TEST(InterpolateSamples, LeavesOutWhatLiesOffTheSurface)
{
    const TriangleMesh block = block_with_top(4, [](double, double) { return 0; });
    const int centre = 25 + 2 * 5 + 2; // of the top
    const auto through = [&](double height)
    {
        TriangleMesh mesh = block;
        Points samples = block.vertices;
        const Point lifted = samples[centre] + Point(0, 0, height), above = Point(0.17, 0.08, height);
        samples[centre] = lifted;
        samples.push_back(above);
        interpolate_samples(mesh, seat_samples(find_nearest_samples(mesh.vertices, samples), samples.size()), samples);
        EXPECT_TRUE(checks::examine_mesh(mesh).is_closed_oriented_manifold());
        return std::pair(count_samples_among(mesh.vertices, {lifted}), count_samples_among(mesh.vertices, {above}));
    };
    EXPECT_EQ(through(0.05), std::pair(1, 1));
    EXPECT_EQ(through(0.2), std::pair(0, 0));
}

TEST(InterpolateSamples, ReachesSamplesOnEdges)
{
    TriangleMesh mesh = block_with_top(4, [](double, double) { return 0; });
    Points samples = mesh.vertices;
    samples.emplace_back(0.125, 0.25, 0);
    std::vector<int> seats(samples.size() - 1);
    std::iota(seats.begin(), seats.end(), 0);
    interpolate_samples(mesh, seats, samples);
    const checks::MeshReport report = checks::examine_mesh(mesh);
    EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
    EXPECT_NEAR(report.volume, 1, 1e-12);
    EXPECT_EQ(count_samples_among(mesh.vertices, samples), int(samples.size()));
    EXPECT_EQ(mesh.vertices.size(), samples.size());
}

TEST(InterpolateSamples, IsTheSameForAnyNumberOfThreads)
{
    const Points samples = shapes::ellipsoid(6000, Vector(0.4, 0.3, 0.2), 1).points;
    const TriangleMesh one = crust_of(samples, true, 1), three = crust_of(samples, true, 3);
    EXPECT_EQ(one.vertices, three.vertices);
    EXPECT_EQ(one.triangles, three.triangles);
}

TEST(NearestSamples, AreThoseOfEveryPair)
{
    Points samples = shapes::sphere(500, 1, 3).points;
    samples.insert(samples.end(), samples.begin(), samples.begin() + 250); // of equal ones the first counts
    Points points;
    for (const Point& sample : samples)
    {
        const Points near = shapes::with_noise(Points(20, sample), 0.02, unsigned(points.size()));
        points.insert(points.end(), near.begin(), near.end());
        points.push_back(sample);
        if (points.size() % 35 == 0)
            points.push_back(Point(40, 0, 0)); // far from the last ones
    }
    for (const Points& few : {samples, Points(3, samples[0])})
    {
        const NearestSamples nearest = find_nearest_samples(points, few);
        for (std::size_t i = 0; i < points.size(); ++i)
        {
            int best = 0;
            for (int k = 1; k < int(few.size()); ++k)
                if ((points[i] - few[k]).squaredNorm() < (points[i] - few[best]).squaredNorm())
                    best = k;
            ASSERT_EQ(nearest.sample[i], best);
            EXPECT_DOUBLE_EQ(nearest.squared[i], (points[i] - few[best]).squaredNorm());
        }
    }
}

TEST(WeldClusters, MakesOneVertexOfASamplesCell)
{
    const Points points = shapes::torus(3000, 1, 0.4, 2).points, samples = UnitFrame(points).to_unit(points);
    PhaseTimes times;
    const LabelledBalls labelled = label_polar_balls(samples, {}, {}, times);
    const CrustPolygons polygons = list_crust_polygons(labelled.regular, labelled.labels);
    const NearestSamples nearest = find_nearest_samples(polygons.vertices, samples);
    const WeldedCrust welded =
        weld_clusters(polygons, std::vector<double>(polygons.vertices.size(), labelled.spacing), &nearest);
    const checks::MeshReport report = checks::examine_mesh(welded.mesh);
    EXPECT_TRUE(report.is_closed_oriented_manifold());
    EXPECT_EQ(report.genus(), 1);
    EXPECT_GT(polygons.vertices.size(), 4 * samples.size());
    EXPECT_LT(welded.mesh.vertices.size(), 1.1 * double(samples.size()));
    for (std::size_t v = 0; v < welded.corner.size(); ++v)
        EXPECT_EQ(welded.mesh.vertices[v], polygons.vertices[welded.corner[v]]);
}

TEST(SeatSamples, GivesEachSampleTheNearestOfItsVertices)
{
    const Points samples = {Point(0, 0, 0), Point(1, 0, 0), Point(9, 0, 0)};
    const Points vertices = {Point(0.2, 0, 0), Point(0.1, 0, 0), Point(0.8, 0, 0), Point(0.4, 0, 0)};
    EXPECT_EQ(seat_samples(find_nearest_samples(vertices, samples), samples.size()), (std::vector<int>{-1, 0, 1, -1}));
}

TEST(FlipEdges, LaysEdgesAlongARidge)
{
    // The ridge runs along the diagonals that the grid does not have.
    const auto roof = [](double x, double y) { return -std::abs(x + y - 1); };
    TriangleMesh mesh = block_with_top(8, roof);
    HalfEdgeMesh edited(mesh, pair_half_edges(mesh));
    EXPECT_GE(flip_edges(edited), 8);
    const checks::MeshReport report = checks::examine_mesh(mesh);
    EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
    // 1 below the top's level, less the two halves of the roof.
    EXPECT_NEAR(report.volume, 1 - 1.0 / 3, 1e-12);
    EXPECT_EQ(flip_edges(edited), 0);
}

TEST(FlipEdges, MakesFlatPartsDelaunay)
{
    TriangleMesh mesh = block_with_top(6, [](double, double) { return 0; });
    for (Point& p : mesh.vertices)
        p.x() += 3 * p.y(); // sheared: the other diagonals are shorter
    HalfEdgeMesh edited(mesh, pair_half_edges(mesh));
    EXPECT_GT(flip_edges(edited), 2 * 36 - 1);
    EXPECT_TRUE(checks::examine_mesh(mesh).is_closed_oriented_manifold());
    EXPECT_NEAR(checks::examine_mesh(mesh).volume, 1, 1e-12);
}

TEST(FlipEdges, BeginsNearWhatChanged)
{
    const auto roof = [](double x, double y) { return -std::abs(x + y - 1); };
    TriangleMesh mesh = block_with_top(8, roof);
    HalfEdgeMesh edited(mesh, pair_half_edges(mesh));
    std::vector<char> changed(mesh.vertices.size(), 0);
    EXPECT_EQ(flip_edges(edited, {}, &changed), 0);
    changed[81 + 4 * 9 + 4] = 1; // in the middle of the top
    EXPECT_GE(flip_edges(edited, {}, &changed), 2);
    changed.assign(changed.size(), 1);
    flip_edges(edited, {}, &changed);
    EXPECT_EQ(flip_edges(edited), 0);
}

TEST(FlipEdges, LeavesATetrahedronAlone)
{
    TriangleMesh mesh;
    mesh.vertices = {Point(0, 0, 0), Point(1, 0, 0), Point(0, 1, 0), Point(0.3, 0.3, 0.01)};
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    HalfEdgeMesh edited(mesh, pair_half_edges(mesh));
    EXPECT_EQ(flip_edges(edited), 0);
}

TEST(HalfEdgeMesh, RefusesToTurnTrianglesOver)
{
    TriangleMesh mesh = block_with_top(4, [](double, double) { return 0; });
    HalfEdgeMesh edited(mesh, pair_half_edges(mesh));
    const int centre = 25 + 2 * 5 + 2; // of the top
    EXPECT_FALSE(edited.move(centre, Point(0.9, 0.5, 0)));
    EXPECT_EQ(mesh.vertices[centre], Point(0.5, 0.5, 0));
    EXPECT_TRUE(edited.move(centre, Point(0.55, 0.5, 0)));
    EXPECT_FALSE(edited.split(0, Point(0.9, 0.9, 0)));
    const auto corners = mesh.triangles[0];
    const std::size_t before = mesh.vertices.size();
    EXPECT_TRUE(
        edited.split(0, (mesh.vertices[corners[0]] + mesh.vertices[corners[1]] + mesh.vertices[corners[2]]) / 3));
    EXPECT_EQ(mesh.vertices.size(), before + 1);
    EXPECT_TRUE(checks::examine_mesh(mesh).is_closed_oriented_manifold());
}

TEST(HalfEdgeMesh, SplitsAnEdgeUnlessATriangleTurnsOver)
{
    TriangleMesh mesh = block_with_top(4, [](double, double) { return 0; });
    HalfEdgeMesh edited(mesh, pair_half_edges(mesh));
    const int h = 0; // of a triangle in the top
    const Point a = mesh.vertices[edited.origin(h)], b = mesh.vertices[edited.target(h)];
    const std::size_t vertices = mesh.vertices.size(), triangles = mesh.triangles.size();
    EXPECT_FALSE(edited.split_edge(h, a + 3 * (b - a)));
    EXPECT_EQ(mesh.vertices.size(), vertices);
    EXPECT_TRUE(edited.split_edge(h, (a + b) / 2));
    EXPECT_EQ(mesh.vertices.size(), vertices + 1);
    EXPECT_EQ(mesh.triangles.size(), triangles + 2);
    EXPECT_EQ(edited.degree(int(vertices)), 4);
    int around = 0;
    edited.for_each_from(int(vertices), [&](int g) { around += edited.origin(g) == int(vertices); });
    EXPECT_EQ(around, 4);
    const checks::MeshReport report = checks::examine_mesh(mesh);
    EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
    EXPECT_NEAR(report.volume, 1, 1e-12);
    EXPECT_TRUE(pair_half_edges(mesh).faulty.empty());
}

TEST(CollapseShortEdges, VerticesThatStayAreAllThatIsLeft)
{
    const Points samples = shapes::sphere(3000, 0.5, 1).points;
    const TriangleMesh crust = crust_of(samples, false);
    EdgeCollapseOptions options;
    options.never_above = 3;
    for (std::size_t v = 0; v < crust.vertices.size(); ++v)
        options.stays.push_back(v % 3 == 0);
    TriangleMesh mesh = crust;
    const std::vector<double> scale(crust.vertices.size(), 0.05);
    const std::vector<int> merged(crust.vertices.size(), 1);
    const std::vector<int> former = collapse_short_edges(mesh, pair_half_edges(mesh), scale, merged, options);
    EXPECT_TRUE(checks::examine_mesh(mesh).is_closed_oriented_manifold());
    int stayed = 0;
    for (std::size_t v = 0; v < former.size(); ++v)
        if (former[v] % 3 == 0)
        {
            ++stayed;
            EXPECT_EQ(mesh.vertices[v], crust.vertices[former[v]]);
        }
    EXPECT_EQ(stayed, int(crust.vertices.size() + 2) / 3);
    EXPECT_LE(former.size(), 1.01 * stayed);
}

} // namespace
