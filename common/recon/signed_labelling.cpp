#include <recon/signed_labelling.h>

#include <recon/parallel.h>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <queue>

namespace recon
{
namespace
{

/// Union-find in which each node knows whether its label equals its representative's.
class ParityForest
{
public:
    explicit ParityForest(int n) : parent_(std::size_t(n)), parity_(std::size_t(n), 0)
    {
        for (int i = 0; i < n; ++i)
            parent_[i] = i;
    }
    /// Representative; `parity` is turned over for each difference on the way.
    int find(int i, int& parity)
    {
        int root = i, total = 0;
        while (parent_[root] != root)
        {
            total ^= parity_[root];
            root = parent_[root];
        }
        parity ^= total;
        while (parent_[i] != root && i != root)
        {
            const int next = parent_[i], rest = total ^ parity_[i];
            parent_[i] = root;
            parity_[i] = char(total);
            total = rest;
            i = next;
        }
        return root;
    }
    /// Makes the labels of a and b equal, if they are in different clusters.
    void join(int a, int b)
    {
        int ignored = 0;
        a = find(a, ignored);
        b = find(b, ignored);
        if (a != b)
            hang(std::max(a, b), std::min(a, b), 0);
    }
    /// Both must be representatives.
    void hang(int child, int parent, int parity)
    {
        parent_[child] = parent;
        parity_[child] = char(parity);
    }

private:
    std::vector<int> parent_;
    std::vector<char> parity_;
};

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

/// Rows of neighbours with weights, one per node.
struct Rows
{
    struct Entry
    {
        int node;
        double weight;
    };
    std::vector<int> first;
    std::vector<Entry> entries;

    Rows(const SignedGraph& graph, int threads)
        : first(std::size_t(graph.nodes) + 1, 0), entries(2 * graph.edges.size())
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
                            });
        };
        for_all([&](int from, int, double) { ++first[from + 1]; });
        for (int i = 0; i < graph.nodes; ++i)
            first[i + 1] += first[i];
        std::vector<int> next(first.begin(), first.end() - 1);
        for_all([&](int from, int to, double weight) { entries[next[from]++] = {to, weight}; });
    }
    /// Weight that agrees with the node's label minus weight that does not.
    double agreement(int node, const std::vector<Side>& labels) const
    {
        double sum = 0;
        for (int k = first[node]; k < first[node + 1]; ++k)
            sum += labels[entries[k].node] == labels[node] ? entries[k].weight : -entries[k].weight;
        return sum;
    }
};

/// Joins the roots, and the pairs that are merged whatever the edges say. `root` becomes one of the roots, -1 if there
/// is none.
ParityForest join_certain(const SignedGraph& graph, int& root)
{
    ParityForest forest(graph.nodes);
    root = -1;
    for (int i = 0; i < graph.nodes; ++i)
        if (graph.is_root[i])
        {
            root = root < 0 ? i : root;
            forest.join(root, i);
        }
    for (const auto& pair : graph.merged)
        forest.join(pair[0], pair[1]);
    return forest;
}

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

/// Changes sides of single nodes (never the root) while that lowers the violated weight.
void improve(const Rows& rows, const std::vector<char>& is_root, std::vector<Side>& labels)
{
    // Merged pairs are held together by their edges' weight alone here; it is large.
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
        if (is_root[i] || !(rows.agreement(i, labels) < -1e-9))
            continue;
        labels[i] = opposite(labels[i]);
        for (int k = rows.first[i]; k < rows.first[i + 1]; ++k)
        {
            const int other = rows.entries[k].node;
            if (!is_waiting[other])
            {
                is_waiting[other] = 1;
                waiting.push(other);
            }
        }
    }
}

/// \param forest clusters to begin with; `root` in one of them, -1 if there is none.
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
    std::priority_queue<Candidate> queue(std::less<Candidate>(), std::move(initial));
    while (!queue.empty())
    {
        const Candidate top = queue.top();
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

/// Of the root 1; above 0 is outer. 0 for all if there is no root.
std::vector<double> find_potential(const SignedGraph& graph, ParityForest& forest, int root)
{
    const int n = graph.nodes;
    std::vector<int> unknown(std::size_t(n), -1);
    int unknowns = 0, ignored = 0;
    const int root_cluster = root < 0 ? -1 : forest.find(root, ignored);
    for (int i = 0; i < n; ++i)
        if (forest.find(i, ignored) == i && i != root_cluster)
            unknown[i] = unknowns++;
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns), diagonal = Eigen::VectorXd::Constant(unknowns, 1e-6);
    for (const SignedEdge& e : graph.edges)
    {
        const int a = forest.find(e.a, ignored), b = forest.find(e.b, ignored);
        if (a == b)
            continue;
        for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)})
        {
            if (from == root_cluster)
                continue;
            diagonal[unknown[from]] += std::abs(e.weight);
            if (to == root_cluster)
                right[unknown[from]] += e.weight;
            else
                entries.emplace_back(unknown[from], unknown[to], -e.weight);
        }
    }
    for (int i = 0; i < unknowns; ++i)
        entries.emplace_back(i, i, diagonal[i]);
    Eigen::SparseMatrix<double, Eigen::RowMajor> laplacian(unknowns, unknowns);
    laplacian.setFromTriplets(entries.begin(), entries.end());
    Eigen::ConjugateGradient<Eigen::SparseMatrix<double, Eigen::RowMajor>, Eigen::Lower | Eigen::Upper> solver;
    solver.setTolerance(1e-4);
    solver.setMaxIterations(1000);
    solver.compute(laplacian);
    const Eigen::VectorXd potential = solver.solve(right);
    std::vector<double> result(std::size_t(n), 1);
    for (int i = 0; i < n; ++i)
    {
        const int cluster = forest.find(i, ignored);
        if (cluster != root_cluster)
            result[i] = potential[unknown[cluster]];
    }
    return result;
}

std::vector<Side> threshold(const std::vector<double>& potential)
{
    std::vector<Side> labels;
    for (const double p : potential)
        labels.push_back(p > 0 ? Side::outer : Side::inner);
    return labels;
}

/// Joins the nodes on which the potential leaves no doubt, those of either side.
void join_clear(const std::vector<double>& potential, ParityForest& forest, int root)
{
    constexpr double clear = 0.5; // nearer to a side than to the middle
    int inner = -1;
    for (int i = 0; i < int(potential.size()); ++i)
    {
        if (!(std::abs(potential[i]) > clear))
            continue;
        int& side = potential[i] > 0 ? root : inner;
        side = side < 0 ? i : side;
        forest.join(side, i);
    }
}

} // namespace

std::vector<Side> label_by_contraction(const SignedGraph& graph)
{
    int root = -1;
    ParityForest forest = join_certain(graph, root);
    std::vector<Side> labels = contract(graph, std::move(forest), root);
    improve_labels(graph, labels);
    return labels;
}

std::vector<Side> label_by_potential(const SignedGraph& graph)
{
    int root = -1;
    ParityForest forest = join_certain(graph, root);
    std::vector<Side> labels = threshold(find_potential(graph, forest, root));
    improve_labels(graph, labels);
    return labels;
}

std::vector<Side> label_by_best(const SignedGraph& graph, int threads)
{
    const Rows rows(graph, threads);
    int root = -1;
    ParityForest forest = join_certain(graph, root);
    const std::vector<double> potential = find_potential(graph, forest, root);
    std::vector<Side> labels = threshold(potential), others;
    double energy = 0, energy_of_others = 0;
    parallel_invoke(
        threads,
        [&]
        {
            join_clear(potential, forest, root);
            others = contract(graph, std::move(forest), root);
            improve(rows, graph.is_root, others);
            energy_of_others = measure_energy(graph, others);
        },
        [&]
        {
            improve(rows, graph.is_root, labels);
            energy = measure_energy(graph, labels);
        });
    return energy < energy_of_others ? labels : others;
}

void improve_labels(const SignedGraph& graph, std::vector<Side>& labels, int threads)
{
    improve(Rows(graph, threads), graph.is_root, labels);
}

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
