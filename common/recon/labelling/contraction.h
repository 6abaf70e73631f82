#pragma once

#include <recon/labelling/parity_forest.h>
#include <recon/labelling/signed_graph.h>

#include <vector>

namespace recon
{

/// Greedy additive contraction with parity: the edge of largest |weight| is contracted first, a negative one turning
/// the absorbed cluster over; parallel edges add up. What no chain of edges ties to the root is inner. \param forest
/// clusters to begin with; `root` in one of them, -1 if there is none.
std::vector<Side> contract(const SignedGraph& graph, ParityForest forest, int root);

} // namespace recon
