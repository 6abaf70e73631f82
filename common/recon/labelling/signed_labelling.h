#pragma once

#include <recon/labelling/signed_graph.h>

#include <vector>

namespace recon
{

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

} // namespace recon
