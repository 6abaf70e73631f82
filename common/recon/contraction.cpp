#include <recon/contraction.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <queue>

namespace recon
{
namespace
{

/// Weights of the edges between clusters, by pair: open addressing, deletion by tombstone.
class PairWeights
{
public:
    explicit PairWeights(std::size_t expected)
    {
        std::size_t size = 16;
        while (size < 3 * expected)
            size *= 2;
        slots_.resize(size);
    }
    /// Weight of the pair, null if it has none.
    double* find(int a, int b)
    {
        const std::uint64_t key = key_of(a, b);
        for (std::size_t i = slot_of(key); slots_[i].key != empty; i = (i + 1) & (slots_.size() - 1))
            if (slots_[i].key == key)
                return &slots_[i].weight;
        return nullptr;
    }
    void insert(int a, int b, double weight)
    {
        if (4 * (used_ + 1) > 3 * slots_.size())
            grow();
        std::size_t i = slot_of(key_of(a, b));
        while (slots_[i].key != empty)
            i = (i + 1) & (slots_.size() - 1);
        slots_[i] = {key_of(a, b), weight};
        ++used_;
    }
    void erase(int a, int b)
    {
        const std::uint64_t key = key_of(a, b);
        for (std::size_t i = slot_of(key); slots_[i].key != empty; i = (i + 1) & (slots_.size() - 1))
            if (slots_[i].key == key)
            {
                slots_[i].key = tombstone;
                return;
            }
    }

private:
    static constexpr std::uint64_t empty = ~std::uint64_t(0), tombstone = empty - 1;
    struct Slot
    {
        std::uint64_t key = empty;
        double weight = 0;
    };
    static std::uint64_t key_of(int a, int b)
    {
        return (std::uint64_t(std::uint32_t(std::min(a, b))) << 32) | std::uint32_t(std::max(a, b));
    }
    std::size_t slot_of(std::uint64_t key) const
    {
        key *= 0x9e3779b97f4a7c15u;
        return std::size_t(key ^ (key >> 29)) & (slots_.size() - 1);
    }
    void grow()
    {
        std::vector<Slot> old(slots_.size() * 2);
        old.swap(slots_);
        used_ = 0;
        for (const Slot& slot : old)
            if (slot.key < tombstone)
            {
                std::size_t i = slot_of(slot.key);
                while (slots_[i].key != empty)
                    i = (i + 1) & (slots_.size() - 1);
                slots_[i] = slot;
                ++used_;
            }
    }
    std::vector<Slot> slots_;
    std::size_t used_ = 0;
};

/// By a, then b; equal pairs keep their order.
void sort_by_ends(std::vector<SignedEdge>& edges, int nodes)
{
    std::vector<int> first(std::size_t(nodes) + 1, 0);
    for (const SignedEdge& e : edges)
        ++first[e.a + 1];
    for (int i = 0; i < nodes; ++i)
        first[i + 1] += first[i];
    std::vector<SignedEdge> sorted(edges.size());
    std::vector<int> next(first.begin(), first.end() - 1);
    for (const SignedEdge& e : edges)
        sorted[next[e.a]++] = e;
    for (int i = 0; i < nodes; ++i)
        std::stable_sort(sorted.begin() + first[i], sorted.begin() + first[i + 1],
                         [](const SignedEdge& x, const SignedEdge& y) { return x.b < y.b; });
    edges.swap(sorted);
}

struct Candidate
{
    double strength; ///< |weight| when it was queued
    int a, b;
    bool operator<(const Candidate& other) const
    {
        if (strength != other.strength)
            return strength < other.strength;
        return a != other.a ? a > other.a : b > other.b; // a fixed order among equals
    }
};

} // namespace

std::vector<Side> contract(const SignedGraph& graph, ParityForest forest, int root)
{
    const int n = graph.nodes;

    // The graph between clusters. Neighbour lists may name pairs that are gone; the weights know.
    std::vector<SignedEdge> sorted;
    sorted.reserve(graph.edges.size());
    for (const SignedEdge& e : graph.edges)
    {
        int parity = 0;
        const int a = forest.find(e.a, parity), b = forest.find(e.b, parity);
        if (a != b)
            sorted.push_back({std::min(a, b), std::max(a, b), parity ? -e.weight : e.weight});
    }
    sort_by_ends(sorted, n);
    PairWeights weights(sorted.size());
    std::vector<std::vector<int>> neighbours(static_cast<std::size_t>(n));
    std::vector<Candidate> initial;
    for (std::size_t i = 0; i < sorted.size();)
    {
        const int a = sorted[i].a, b = sorted[i].b;
        double sum = 0;
        for (; i < sorted.size() && sorted[i].a == a && sorted[i].b == b; ++i)
            sum += sorted[i].weight;
        weights.insert(a, b, sum);
        neighbours[a].push_back(b);
        neighbours[b].push_back(a);
        initial.push_back({std::abs(sum), a, b});
    }
    // Those to begin with, sorted once, take less time than in the queue, which holds what changed since.
    std::sort(initial.begin(), initial.end());
    std::priority_queue<Candidate> queue;
    while (!queue.empty() || !initial.empty())
    {
        const bool is_unchanged = queue.empty() || (!initial.empty() && queue.top() < initial.back());
        const Candidate top = is_unchanged ? initial.back() : queue.top();
        if (is_unchanged)
            initial.pop_back();
        else
            queue.pop();
        const double* weight = weights.find(top.a, top.b);
        if (!weight || std::abs(*weight) != top.strength || top.strength == 0)
            continue;
        const int parity = *weight < 0 ? 1 : 0;
        const bool a_has_more = neighbours[top.a].size() >= neighbours[top.b].size();
        const int keep = a_has_more ? top.a : top.b, gone = a_has_more ? top.b : top.a;
        weights.erase(keep, gone);
        forest.hang(gone, keep, parity);
        for (const int other : neighbours[gone])
        {
            const double* found = weights.find(gone, other);
            if (!found)
                continue;
            const double moved = parity ? -*found : *found;
            weights.erase(gone, other);
            double sum = moved;
            if (double* present = weights.find(keep, other))
                sum = *present += moved;
            else
            {
                weights.insert(keep, other, moved);
                neighbours[keep].push_back(other);
                neighbours[other].push_back(keep);
            }
            queue.push({std::abs(sum), std::min(keep, other), std::max(keep, other)});
        }
        std::vector<int>().swap(neighbours[gone]);
    }

    std::vector<Side> labels(std::size_t(n), Side::inner);
    int root_parity = 0;
    const int root_cluster = root < 0 ? -1 : forest.find(root, root_parity);
    for (int i = 0; i < n; ++i)
    {
        int parity = root_parity;
        if (forest.find(i, parity) == root_cluster)
            labels[i] = parity ? Side::inner : Side::outer;
    }
    return labels;
}

} // namespace recon
