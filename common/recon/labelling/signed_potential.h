#pragma once

#include <recon/labelling/parity_forest.h>
#include <recon/labelling/signed_graph.h>

#include <vector>

namespace recon
{

/// Per node the least-squares potential: 1 at the root, equal across attractions, opposite across repulsions, one value
/// per cluster of `forest` (signed Laplacian, conjugate gradients). Above 0 is outer; 0 for all if there is no root
/// (-1).
std::vector<double> find_potential(const SignedGraph& graph, ParityForest& forest, int root);

} // namespace recon
