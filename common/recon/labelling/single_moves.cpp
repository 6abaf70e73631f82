#include <recon/labelling/single_moves.h>

#include <recon/parallel.h>

#include <queue>

namespace recon
{
namespace
{

/// Weight of merged pairs. That of their edges can be less than what speaks against it: of two balls that fill a sphere
/// one may have all the votes and the other half of the surface.
constexpr double inseparable = 1e9;

} // namespace

SingleMoves::SingleMoves(const SignedGraph& graph, int threads)
    : graph_(graph), first_(std::size_t(graph.nodes) + 1, 0), entries_(2 * (graph.edges.size() + graph.merged.size()))
{
    // Each thread reads all edges and keeps what belongs to its nodes.
    const auto for_all = [&](auto&& call)
    {
        parallel_shares(std::size_t(graph.nodes), threads,
                        [&](const Share& own)
                        {
                            for (const SignedEdge& e : graph.edges)
                            {
                                if (own.has(e.a))
                                    call(e.a, e.b, e.weight);
                                if (own.has(e.b))
                                    call(e.b, e.a, e.weight);
                            }
                            for (const auto& [a, b] : graph.merged)
                            {
                                if (own.has(a))
                                    call(a, b, inseparable);
                                if (own.has(b))
                                    call(b, a, inseparable);
                            }
                        });
    };
    for_all([&](int from, int, double) { ++first_[from + 1]; });
    for (int i = 0; i < graph.nodes; ++i)
        first_[i + 1] += first_[i];
    std::vector<int> next(first_.begin(), first_.end() - 1);
    for_all([&](int from, int to, double weight) { entries_[next[from]++] = {to, weight}; });
}

double SingleMoves::agreement(int node, const std::vector<Side>& labels) const
{
    double sum = 0;
    for (int k = first_[node]; k < first_[node + 1]; ++k)
        sum += labels[entries_[k].node] == labels[node] ? entries_[k].weight : -entries_[k].weight;
    return sum;
}

void SingleMoves::improve(std::vector<Side>& labels) const
{
    const int n = int(labels.size());
    std::queue<int> waiting;
    std::vector<char> is_waiting(labels.size(), 1);
    for (int i = 0; i < n; ++i)
        waiting.push(i);
    // Each flip lowers the energy, so this ends; rounding could make two flips undo each other for ever.
    for (long long budget = 20ll * n; !waiting.empty() && budget > 0; --budget)
    {
        const int i = waiting.front();
        waiting.pop();
        is_waiting[i] = 0;
        if (graph_.is_root[i] || !(agreement(i, labels) < -1e-9))
            continue;
        labels[i] = opposite(labels[i]);
        for (int k = first_[i]; k < first_[i + 1]; ++k)
        {
            const int other = entries_[k].node;
            if (!is_waiting[other])
            {
                is_waiting[other] = 1;
                waiting.push(other);
            }
        }
    }
}

} // namespace recon
