#include <recon/labelling/signed_graph.h>

#include <cmath>

namespace recon
{

std::vector<double> measure_margins(const SignedGraph& graph, const std::vector<Side>& labels)
{
    std::vector<double> agreement(std::size_t(graph.nodes), 0), total(std::size_t(graph.nodes), 0);
    for (const SignedEdge& e : graph.edges)
    {
        const double agreed = labels[e.a] == labels[e.b] ? e.weight : -e.weight, size = std::abs(e.weight);
        agreement[e.a] += agreed;
        agreement[e.b] += agreed;
        total[e.a] += size;
        total[e.b] += size;
    }
    for (int i = 0; i < graph.nodes; ++i)
        agreement[i] = total[i] > 0 ? agreement[i] / total[i] : 1;
    return agreement;
}

Violation measure_violated_repulsion(const std::vector<SignedEdge>& edges, const std::vector<Side>& labels)
{
    Violation result;
    for (const SignedEdge& e : edges)
        if (e.weight < 0)
        {
            result.total -= e.weight;
            if (labels[e.a] == labels[e.b])
                result.violated -= e.weight;
        }
    return result;
}

double measure_energy(const SignedGraph& graph, const std::vector<Side>& labels)
{
    double energy = 0;
    for (const SignedEdge& e : graph.edges)
        if ((labels[e.a] == labels[e.b]) != (e.weight > 0))
            energy += std::abs(e.weight);
    return energy;
}

} // namespace recon
