#include <recon/labelling/ball_link.h>
#include <recon/labelling/crust_repair.h>
#include <recon/labelling/short_handles.h>
#include <recon/mesh/crust_mesh.h>
#include <recon/triangulation/power_diagram.h>

#include "tests/checks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <vector>

using namespace recon;

namespace
{

constexpr int steps = 14;
constexpr double cell = 1.2 / steps;

/// Balls of a grid, those within 0.4 of the centre inner, with a tunnel two balls wide along z, or two that cross, and
/// on demand a small body beside them.
struct PlantedTunnel
{
    std::vector<Ball> balls;
    std::vector<Side> labels;
    Triangulation regular;
    SignedGraph graph;
    std::vector<double> scale;
    double agreement = 0; ///< Of the normals with every ball's planted side [-1..1].

    bool is_crossed;
    static int index(int x, int y, int z) { return (x * (steps + 1) + y) * (steps + 1) + z; }
    bool is_tunnel(int x, int y, int z) const { return (x == 7 || (is_crossed && z == 7)) && (y == 7 || y == 8); }

    /// Each pair of grid neighbours attracts by 1, opposite labels repel by 1; in the middle of the tunnel, `doubt` of
    /// the evidence says that the tunnel is filled.
    explicit PlantedTunnel(double doubt, bool crossed = false, bool has_second_body = false) : is_crossed(crossed)
    {
        std::mt19937 random(1);
        for (int x = 0; x <= steps; ++x)
            for (int y = 0; y <= steps; ++y)
                for (int z = 0; z <= steps; ++z)
                {
                    Point p = cell * Point(x - 7, y - 7, z - 7);
                    for (int k = 0; k < 3; ++k)
                        p[k] += 1e-3 * (random() / 4294967296.0);
                    balls.push_back({p, 0.05});
                    const bool is_second = has_second_body && std::max({x, y, z}) <= 3 && std::min({x, y, z}) >= 2;
                    const bool is_inner = is_second || (p.norm() < 0.4 && !is_tunnel(x, y, z));
                    labels.push_back(is_inner ? Side::inner : Side::outer);
                }
        regular = PowerDiagram(balls).triangulation();
        scale.assign(balls.size(), 0.05);
        graph.nodes = int(balls.size());
        graph.is_root.assign(balls.size(), 0);
        for (std::size_t c = std::size_t(regular.finite_cells); c < regular.cells.size(); ++c)
            for (const int v : regular.cells[c].vertices)
                if (v >= 0)
                    graph.is_root[v] = 1;
        const auto connect = [&](int x, int y, int z, int x2, int y2, int z2)
        {
            const int a = index(x, y, z), b = index(x2, y2, z2);
            const bool is_middle =
                (is_tunnel(x, y, z) || is_tunnel(x2, y2, z2)) && std::abs(z - 7) <= 1 && std::abs(x - 7) <= 1;
            const double truth = labels[a] == labels[b] ? 1 : -1;
            graph.edges.push_back({a, b, truth * (is_middle ? 1 - doubt : 1)});
            if (is_middle)
                graph.edges.push_back({a, b, -truth * doubt});
        };
        for (int x = 0; x < steps; ++x)
            for (int y = 0; y < steps; ++y)
                for (int z = 0; z < steps; ++z)
                {
                    connect(x, y, z, x + 1, y, z);
                    connect(x, y, z, x, y + 1, z);
                    connect(x, y, z, x, y, z + 1);
                }
    }
    int remove(const ShortHandleOptions& options)
    {
        const auto outwardness = [&, planted = labels](int ball)
        { return planted[ball] == Side::outer ? agreement : -agreement; };
        return remove_short_handles(regular, graph, balls, scale, measure_margins(graph, labels), outwardness, options,
                                    labels);
    }
    checks::MeshReport report() const
    {
        return checks::examine_mesh(triangulate_polygons(list_crust_polygons(regular, labels)));
    }
};

} // namespace

TEST(ShortHandles, EulerCharacteristicAgreesWithTheCrusts)
{
    PlantedTunnel planted(0);
    EXPECT_EQ(planted.report().euler_characteristic, 0);
    EXPECT_EQ(measure_interface_euler(planted.regular, planted.labels), 0);
    for (int z = 0; z <= steps; ++z)
        planted.labels[PlantedTunnel::index(4, 7, z)] = Side::outer;
    EXPECT_LT(planted.report().euler_characteristic, 0);
    EXPECT_EQ(measure_interface_euler(planted.regular, planted.labels), planted.report().euler_characteristic);
}

TEST(ShortHandles, FillsADoubtfulTunnelThatIsWiderThanABall)
{
    PlantedTunnel planted(0.45);
    ASSERT_EQ(planted.report().genus(), 1);
    const std::vector<char> is_small(planted.balls.size(), 1);
    EXPECT_EQ(cut_handles(planted.regular, planted.graph.is_root, is_small,
                          measure_margins(planted.graph, planted.labels), planted.labels),
              0)
        << "no single ball closes it";
    EXPECT_GE(planted.remove({}), 2);
    const checks::MeshReport report = planted.report();
    EXPECT_TRUE(report.is_closed_oriented_manifold());
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.genus(), 0);
}

TEST(ShortHandles, FillsATunnelOfOneBodyBesideAnother)
{
    // Together they have the Euler characteristic of a sphere.
    PlantedTunnel planted(0.45, false, true);
    ASSERT_EQ(planted.report().euler_characteristic, 2);
    ASSERT_EQ(planted.report().components, 2);
    EXPECT_GE(planted.remove({}), 2);
    EXPECT_EQ(planted.report().euler_characteristic, 4);
    EXPECT_EQ(planted.report().components, 2);
    EXPECT_EQ(planted.remove({}), 0) << "spheres have no handles";
}

TEST(ShortHandles, LeavesWhatIsCertainOrLong)
{
    PlantedTunnel certain(0);
    EXPECT_EQ(certain.remove({}), 0);
    EXPECT_EQ(certain.report().genus(), 1);

    // The ring runs from one mouth of the tunnel round the ball to the other: more than ten grid steps.
    PlantedTunnel doubtful(0.45);
    ShortHandleOptions options;
    options.longest_ring = 6 * cell / 0.05;
    EXPECT_EQ(doubtful.remove(options), 0);
    options.longest_ring = 40;
    options.largest_support = 1;
    EXPECT_EQ(doubtful.remove(options), 0);
    EXPECT_EQ(doubtful.report().genus(), 1);
}

TEST(ShortHandles, HandlesThatGoTogetherShareTheEvidence)
{
    // Removed from a support of 39 on, with the tunnel that crosses it from 45 on; 138 if each had to bear all of it.
    for (const bool is_crossed : {false, true})
    {
        PlantedTunnel planted(0.45, is_crossed);
        ASSERT_EQ(planted.report().genus(), is_crossed ? 3 : 1);
        ShortHandleOptions options;
        options.largest_support = 60;
        planted.remove(options);
        EXPECT_EQ(planted.report().genus(), 0) << is_crossed;
    }
}

TEST(ShortHandles, LeavesWhatNormalsAgreeWith)
{
    for (const double agreement : {0.9, 0.2, -0.9})
    {
        PlantedTunnel planted(0.45);
        planted.agreement = agreement;
        EXPECT_EQ(planted.remove({}) > 0, agreement < 0.5) << agreement;
        EXPECT_EQ(planted.report().genus(), agreement < 0.5 ? 0 : 1) << agreement;
    }
}

TEST(ShortHandles, TurnsBallsFarLargerThanTheLocalScale)
{
    // As where an open scan is closed: the balls are large, the samples of its rim are close.
    PlantedTunnel planted(0.45);
    planted.scale.assign(planted.balls.size(), 0.005);
    ShortHandleOptions options;
    options.longest_ring = options.largest_support = 1e4;
    EXPECT_GE(planted.remove(options), 2);
    EXPECT_EQ(planted.report().genus(), 0);
}

TEST(ShortHandles, RemovesALongHandleThatItsLargeBallsDoNotSupport)
{
    PlantedTunnel planted(0.45);
    planted.scale.assign(planted.balls.size(), 0.0005);
    ShortHandleOptions options;
    options.least_share = 0;
    EXPECT_EQ(planted.remove(options), 0);
    options.least_share = ShortHandleOptions().least_share;
    EXPECT_GE(planted.remove(options), 2);
    EXPECT_EQ(planted.report().genus(), 0);
}

// One link serves all balls in turn: nothing of the last may be left. By the definition: balls that share a cell with
// it, joined where they share one of these and their side.
TEST(BallLink, HasTheNeighboursAndTheirPieces)
{
    const PlantedTunnel planted(0.8, true);
    const int n = int(planted.labels.size());
    const CellsAtVertices at = list_cells_at_vertices(planted.regular, n);
    BallLink link(planted.labels.size());
    int parted = 0;
    for (int ball = 0; ball < n; ++ball)
    {
        link.build(planted.regular, at, ball, planted.labels);
        std::map<int, std::set<int>> joined;
        for (const auto& cell : planted.regular.cells)
            if (std::count(cell.vertices.begin(), cell.vertices.end(), ball) > 0)
                for (const int a : cell.vertices)
                    for (const int b : cell.vertices)
                        if (a >= 0 && b >= 0 && a != ball && b != ball && planted.labels[a] == planted.labels[b])
                            joined[a].insert(b);
        std::set<int> balls(link.balls().begin(), link.balls().end());
        ASSERT_EQ(balls.size(), link.balls().size());
        ASSERT_EQ(balls.size(), joined.size());
        std::map<Side, int> pieces;
        while (!balls.empty())
        {
            std::vector<int> piece = {*balls.begin()};
            ++pieces[planted.labels[piece.front()]];
            balls.erase(balls.begin());
            for (std::size_t k = 0; k < piece.size(); ++k)
                for (const int other : joined.at(piece[k]))
                    if (balls.erase(other) > 0)
                        piece.push_back(other);
        }
        for (const Side side : {Side::inner, Side::outer})
        {
            ASSERT_EQ(link.count_pieces(side), pieces[side]);
            ASSERT_EQ(int(link.pieces(side).size()), pieces[side]);
        }
        parted += pieces[Side::inner] > 1 || pieces[Side::outer] > 1;
    }
    EXPECT_GT(parted, 10);
}

TEST(ShortHandles, TurnsFewBallsThatCouldStayAndHaveEvidence)
{
    int turned = 0, idle = 0;
    for (const unsigned seed : {1, 2, 3, 4, 5})
    {
        // Labels with many handles, and evidence of random strength for and against them.
        PlantedTunnel planted(0);
        std::mt19937 random(seed);
        const auto uniform = [&] { return random() / 4294967296.0; };
        for (std::size_t i = 0; i < planted.labels.size(); ++i)
            if (std::abs(planted.balls[i].centre.norm() - 0.4) < 0.2 && uniform() < 0.2)
                planted.labels[i] = opposite(planted.labels[i]);
        for (SignedEdge& edge : planted.graph.edges)
            edge.weight = (planted.labels[edge.a] == planted.labels[edge.b] ? 1 : -1) * (1.1 * uniform() - 0.3);
        const std::vector<int> weight(planted.labels.size(), 1);
        const std::vector<char> is_large(planted.labels.size(), 0);
        absorb_islands(planted.regular, planted.graph.is_root, weight, is_large, 0.5, planted.labels);
        const std::vector<Side> before = planted.labels;
        const int euler = measure_interface_euler(planted.regular, before);

        ShortHandleOptions options;
        options.rounds = 1;
        planted.remove(options);
        EXPECT_GT(measure_interface_euler(planted.regular, planted.labels), euler);
        std::vector<Side> after = planted.labels;
        EXPECT_EQ(absorb_islands(planted.regular, planted.graph.is_root, weight, is_large, 0.5, after), 0) << "parted";

        const CellsAtVertices at = list_cells_at_vertices(planted.regular, int(before.size()));
        std::vector<double> evidence(before.size(), 0);
        for (const SignedEdge& edge : planted.graph.edges)
            for (const int ball : {edge.a, edge.b})
                evidence[ball] += planted.labels[edge.a] == planted.labels[edge.b] ? edge.weight : -edge.weight;
        BallLink link(before.size());
        for (int i = 0; i < int(before.size()); ++i)
        {
            turned += planted.labels[i] != before[i];
            link.build(planted.regular, at, i, planted.labels);
            idle += planted.labels[i] != before[i] && evidence[i] < 0 && link.count_pieces(Side::inner) == 1 &&
                    link.count_pieces(Side::outer) == 1;
        }
    }
    // What is turned later can make superfluous what was turned first; without narrowing it is a tenth.
    EXPECT_GT(turned, 100);
    EXPECT_LT(idle, 0.075 * turned);
}
