#include <recon/labelling/contraction.h>
#include <recon/labelling/minimum_cut.h>
#include <recon/labelling/signed_labelling.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <utility>

using namespace recon;

namespace
{

/// A random graph with root 0 and hidden sides, of which a share of the edges tells the wrong thing.
SignedGraph planted_graph(int n, double wrong, unsigned seed, std::vector<Side>& sides)
{
    std::mt19937 random(seed);
    const auto uniform = [&] { return double(random()) / 4294967296.0; };
    SignedGraph graph;
    graph.nodes = n;
    graph.is_root = std::vector<char>(std::size_t(n), 0);
    graph.is_root[0] = 1;
    sides = std::vector<Side>(std::size_t(n), Side::outer);
    for (int i = 1; i < n; ++i)
        sides[i] = random() % 2 ? Side::outer : Side::inner;
    for (int k = 0; k < 8 * n; ++k)
    {
        const int a = int(random() % n), b = int(random() % n);
        if (a == b)
            continue;
        const bool lies = uniform() < wrong;
        const double weight = (lies ? 0.5 : 1.0) * (0.5 + uniform());
        graph.edges.push_back({a, b, ((sides[a] == sides[b]) != lies) ? weight : -weight});
    }
    return graph;
}

double lowest_energy(const SignedGraph& graph)
{
    double lowest = INFINITY;
    for (int mask = 0; mask < 1 << (graph.nodes - 1); ++mask)
    {
        std::vector<Side> labels(graph.nodes, Side::outer);
        for (int i = 1; i < graph.nodes; ++i)
            labels[i] = mask >> (i - 1) & 1 ? Side::inner : Side::outer;
        lowest = std::min(lowest, measure_energy(graph, labels));
    }
    return lowest;
}

/// The strongest edge first, sought among all each time.
std::vector<Side> contract_slowly(const SignedGraph& graph)
{
    std::map<std::pair<int, int>, double> weights;
    for (const SignedEdge& e : graph.edges)
        weights[std::minmax(e.a, e.b)] += e.weight;
    ParityForest forest(graph.nodes);
    while (!weights.empty())
    {
        const auto [pair, weight] =
            *std::max_element(weights.begin(), weights.end(),
                              [](const auto& a, const auto& b) { return std::abs(a.second) < std::abs(b.second); });
        const auto [keep, gone] = pair;
        forest.hang(gone, keep, weight < 0);
        std::map<std::pair<int, int>, double> contracted;
        for (const auto& [ends, other] : weights)
        {
            const auto [a, b] = ends;
            if (ends == pair)
                continue;
            const bool is_moved = a == gone || b == gone;
            contracted[std::minmax(a == gone ? keep : a, b == gone ? keep : b)] +=
                is_moved && weight < 0 ? -other : other;
        }
        weights = std::move(contracted);
    }
    std::vector<Side> labels;
    for (int i = 0; i < graph.nodes; ++i)
    {
        int parity = 0;
        forest.find(0, parity);
        forest.find(i, parity);
        labels.push_back(parity == 0 ? Side::outer : Side::inner);
    }
    return labels;
}

} // namespace

TEST(SignedLabelling, ContractionTakesTheStrongestEdgeFirst)
{
    // Every node is a neighbour of a tenth of the others to begin with, and clusters of nearly all in the end.
    for (const unsigned seed : {1u, 2u, 3u})
    {
        std::vector<Side> sides;
        SignedGraph graph = planted_graph(240, 0.4, seed, sides);
        const std::vector<SignedEdge> more = planted_graph(240, 0.4, seed + 10, sides).edges;
        graph.edges.insert(graph.edges.end(), more.begin(), more.end());
        EXPECT_EQ(contract(graph, ParityForest(graph.nodes), 0), contract_slowly(graph));
    }
}

TEST(SignedLabelling, FindsPlantedSidesInSpiteOfLies)
{
    for (const unsigned seed : {1u, 2u, 3u})
    {
        std::vector<Side> sides;
        const SignedGraph graph = planted_graph(2000, 0.1, seed, sides);
        EXPECT_EQ(label_by_contraction(graph), sides);
        EXPECT_EQ(label_by_potential(graph), sides);
        EXPECT_EQ(label_by_best(graph), sides);
    }
}

TEST(SignedLabelling, MergedNodesStayTogetherWhateverTheirEdgesSay)
{
    // Of two balls that fill one part, the first has the votes, the second most of the surface around it.
    SignedGraph graph;
    graph.nodes = 43;
    graph.is_root.assign(43, 0);
    graph.merged = {{0, 1}};
    graph.edges = {{0, 1, 5}};
    for (int outer = 2; outer < 43; ++outer)
    {
        graph.is_root[outer] = 1;
        graph.edges.push_back({0, outer, -1});
        graph.edges.push_back({1, outer, 0.5});
    }
    std::vector<Side> expected(43, Side::outer);
    expected[0] = expected[1] = Side::inner;
    EXPECT_EQ(label_by_best(graph), expected);
    EXPECT_EQ(label_by_contraction(graph), expected);
}

TEST(SignedLabelling, ComesCloseToTheLowestEnergyOfSmallGraphs)
{
    double found = 0, lowest = 0;
    for (unsigned seed = 0; seed < 40; ++seed)
    {
        std::vector<Side> sides;
        const SignedGraph graph = planted_graph(11, 0.25, seed, sides);
        const double best = measure_energy(graph, label_by_best(graph));
        const double least = lowest_energy(graph);
        EXPECT_LE(best, measure_energy(graph, label_by_potential(graph)));
        EXPECT_GE(best, least - 1e-9);
        found += best;
        lowest += least;
    }
    EXPECT_LT(found, 1.02 * lowest);
}

TEST(SignedLabelling, ContractionSettlesWhatThePotentialLeavesOpen)
{
    double best = 0, contraction = 0, potential = 0;
    for (unsigned seed = 0; seed < 10; ++seed)
    {
        std::vector<Side> sides;
        const SignedGraph graph = planted_graph(500, 0.45, seed, sides);
        best += measure_energy(graph, label_by_best(graph));
        contraction += measure_energy(graph, label_by_contraction(graph));
        potential += measure_energy(graph, label_by_potential(graph));
        EXPECT_EQ(label_by_best(graph, 1), label_by_best(graph, 3));
    }
    EXPECT_LT(best, 0.95 * potential);
    EXPECT_LE(best, 1.01 * contraction);
}

TEST(SignedLabelling, PotentialClosesAHoleThatContractionFallsInto)
{
    // Outside 0 and inside 1 are joined by one heavy attraction (a hole), and kept apart by many light votes between
    // their own small satellites.
    SignedGraph graph;
    graph.nodes = 202;
    graph.is_root = std::vector<char>(std::size_t(graph.nodes), 0);
    graph.is_root[0] = 1;
    graph.edges.push_back({0, 1, 30});
    for (int i = 2; i < 202; i += 2)
    {
        graph.edges.push_back({0, i, 3});
        graph.edges.push_back({1, i + 1, 3});
        graph.edges.push_back({i, i + 1, -1});
    }
    EXPECT_EQ(label_by_contraction(graph)[1], Side::outer);
    const std::vector<Side> labels = label_by_best(graph);
    EXPECT_EQ(labels[1], Side::inner);
    EXPECT_NEAR(measure_energy(graph, labels), 30, 1e-12);
    EXPECT_NEAR(measure_violated_repulsion(graph.edges, labels).share(), 0, 1e-12);
}

TEST(SignedLabelling, WhatNothingReachesIsInner)
{
    SignedGraph graph;
    graph.nodes = 4;
    graph.is_root = {1, 0, 0, 0};
    graph.edges = {{0, 1, 1}, {2, 3, 1}};
    const std::vector<Side> expected = {Side::outer, Side::outer, Side::inner, Side::inner};
    EXPECT_EQ(label_by_contraction(graph), expected);
    EXPECT_EQ(label_by_potential(graph), expected);
    EXPECT_EQ(label_by_best(graph), expected);
    EXPECT_EQ(label_by_minimum_cut(graph, {}), expected);
    graph.merged = {{1, 2}};
    EXPECT_EQ(label_by_contraction(graph), std::vector<Side>(4, Side::outer));
}

TEST(SignedLabelling, MarginsAndViolationsCountWeights)
{
    SignedGraph graph;
    graph.nodes = 3;
    graph.is_root = {1, 0, 0};
    graph.edges = {{0, 1, 3}, {1, 2, -1}, {0, 1, -1}};
    const std::vector<Side> labels = {Side::outer, Side::outer, Side::inner};
    const std::vector<double> margins = measure_margins(graph, labels);
    EXPECT_DOUBLE_EQ(margins[0], 0.5);
    EXPECT_DOUBLE_EQ(margins[1], 0.6);
    EXPECT_DOUBLE_EQ(margins[2], 1);
    EXPECT_DOUBLE_EQ(measure_violated_repulsion(graph.edges, labels).share(), 0.5);
    EXPECT_DOUBLE_EQ(measure_energy(graph, labels), 1);
}

TEST(MinimumCut, AgreesWithBruteForce)
{
    std::mt19937 random(5);
    for (int trial = 0; trial < 50; ++trial)
    {
        SignedGraph graph;
        graph.nodes = 9;
        graph.is_root = std::vector<char>(std::size_t(graph.nodes), 0);
        graph.is_root[0] = 1;
        for (int k = 0; k < 20; ++k)
            graph.edges.push_back({int(random() % 9), int(random() % 9), double(random() % 100)});
        std::vector<TerminalTie> ties;
        for (int k = 0; k < 12; ++k)
            ties.push_back({int(random() % 9), random() % 2 ? Side::outer : Side::inner, double(1 + random() % 100)});
        const auto energy = [&](const std::vector<Side>& labels)
        {
            double sum = measure_energy(graph, labels);
            for (const TerminalTie& tie : ties)
                sum += labels[tie.node] != tie.side ? tie.weight : 0;
            return sum;
        };
        double lowest = INFINITY;
        for (int mask = 0; mask < 256; ++mask)
        {
            std::vector<Side> labels(9, Side::outer);
            for (int i = 1; i < 9; ++i)
                labels[i] = mask >> (i - 1) & 1 ? Side::inner : Side::outer;
            lowest = std::min(lowest, energy(labels));
        }
        EXPECT_NEAR(energy(label_by_minimum_cut(graph, ties)), lowest, 1e-9);
    }
}
