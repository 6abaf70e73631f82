#pragma once

#include <recon/labelling/signed_graph.h>

#include <vector>

namespace recon
{

/// Pulls a node towards a side.
struct TerminalTie
{
    int node;
    Side side;
    double weight; ///< > 0.
};

/// The labels that cut the least weight of attractions and ties: the exact minimum (Boykov and Kolmogorov's maximum
/// flow, from Boost). \pre all edges of `graph` have weight >= 0. Nodes that nothing ties to the root are inner.
std::vector<Side> label_by_minimum_cut(const SignedGraph& graph, const std::vector<TerminalTie>& ties);

} // namespace recon
