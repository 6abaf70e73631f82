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

/// Labels by greedy additive contraction with parity: the edge of largest |weight| is contracted first, a negative one
/// turning the absorbed cluster over; parallel edges add up. What no chain of edges ties to the root is inner. Then
/// single nodes change sides while that lowers the violated weight.
std::vector<Side> label_by_contraction(const SignedGraph& graph);

/// Labels by the signs of the least-squares potential: 1 at the root, equal across attractions, opposite across
/// repulsions (signed Laplacian, conjugate gradients). Sees the whole balance at once, where contraction decides the
/// heaviest edge first: a large hole is a few heavy attractions against thousands of light votes. Then single nodes
/// change sides.
std::vector<Side> label_by_potential(const SignedGraph& graph);

/// The labels with less contradicted weight of those from the potential and from contraction of what the potential
/// leaves open, which is nodes of 0.5 at most: less than a third of those of easy clouds. Contraction from nothing
/// hardly ever comes lower and takes longer. `threads` >= 1 here and below; the result does not depend on it.
std::vector<Side> label_by_best(const SignedGraph& graph, int threads = 1);

/// Changes sides of single nodes (never the root) while that lowers the violated weight.
void improve_labels(const SignedGraph& graph, std::vector<Side>& labels, int threads = 1);

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
