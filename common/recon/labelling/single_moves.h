#pragma once

#include <recon/labelling/signed_graph.h>

#include <vector>

namespace recon
{

/// Changes sides of single nodes (never the root) while that lowers the contradicted weight. Merged pairs on one side
/// stay together.
class SingleMoves
{
public:
    /// Keeps a reference to the graph. \param threads >= 1; the result does not depend on it.
    explicit SingleMoves(const SignedGraph& graph, int threads = 1);

    void improve(std::vector<Side>& labels) const;

private:
    /// Weight that agrees with the node's label minus weight that does not.
    double agreement(int node, const std::vector<Side>& labels) const;

    struct Entry
    {
        int node;
        double weight;
    };
    const SignedGraph& graph_;
    std::vector<int> first_; ///< Of each node's entries.
    std::vector<Entry> entries_;
};

} // namespace recon
