#pragma once

#include <array>
#include <vector>

namespace recon
{

/// Evidence about two nodes: above 0 they are on one side, below 0 on opposite sides.
struct SignedEdge
{
    int a, b;
    double weight;
};

enum class Side : signed char
{
    inner = 0,
    outer = 1
};
inline Side opposite(Side side)
{
    return side == Side::inner ? Side::outer : Side::inner;
}

/// Inside/outside as a two-colouring of a graph of attractions and repulsions.
struct SignedGraph
{
    int nodes = 0;
    std::vector<SignedEdge> edges;          ///< Parallel edges add up.
    std::vector<std::array<int, 2>> merged; ///< Pairs that share one label whatever the edges say.
    std::vector<char> is_root;              ///< Per node: outer, whatever the edges say.
};

/// Per node (weight that agrees - weight that disagrees) / sum of |weight| over its edges; 1 for a node without edges.
std::vector<double> measure_margins(const SignedGraph& graph, const std::vector<Side>& labels);

/// Violated and total weight of the edges with weight < 0 (repulsions).
struct Violation
{
    double violated = 0, total = 0;
    double share() const { return total > 0 ? violated / total : 0; }
};
Violation measure_violated_repulsion(const std::vector<SignedEdge>& edges, const std::vector<Side>& labels);

/// Sum of |weight| of all edges that the labels contradict.
double measure_energy(const SignedGraph& graph, const std::vector<Side>& labels);

} // namespace recon
