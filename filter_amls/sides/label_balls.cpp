#include "label_balls.h"

#include <recon/disjoint_sets.h>
#include <recon/errors.h>
#include <recon/parallel.h>

#include <boost/sort/spreadsort/integer_sort.hpp>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <functional>

namespace recon
{
namespace
{

constexpr int most_rounds = 20;

/// Positions of the ties, heaviest first, where opposite ones count `opposite_factor` times; equal weights in the order
/// of the list, always.
std::vector<int> sort_by_weight(const std::vector<Tie>& ties, float opposite_factor)
{
    // Bit patterns of positive floats sort as the floats do.
    std::vector<std::uint64_t> keys(ties.size());
    for (std::size_t i = 0; i < ties.size(); ++i)
    {
        const float weight = ties[i].opposite ? opposite_factor * ties[i].weight : ties[i].weight;
        std::uint32_t bits;
        std::memcpy(&bits, &weight, sizeof bits);
        keys[i] = std::uint64_t(~bits) << 32 | std::uint32_t(i);
    }
    boost::sort::spreadsort::integer_sort(keys.begin(), keys.end());
    std::vector<int> order(keys.size());
    std::transform(keys.begin(), keys.end(), order.begin(), [](std::uint64_t key) { return int(std::uint32_t(key)); });
    return order;
}

/// The tree of the maximum spanning forest that holds the outside, its nodes numbered by depth: 0 is the outside,
/// parents come before their children.
struct Tree
{
    std::vector<int> node_of_ball; ///< -1 for what no tie links to the outside; the outside comes last.
    std::vector<int> ball_of_node;
    std::vector<int> parent;
    std::vector<int> path; ///< Uppermost node of the heavy path on which a node lies.
    std::vector<std::int8_t> side;

    int size() const { return int(ball_of_node.size()); }

    int lowest_common_ancestor(int a, int b) const
    {
        while (path[a] != path[b])
            if (path[a] > path[b])
                a = parent[path[a]];
            else
                b = parent[path[b]];
        return std::min(a, b);
    }
};

Tree grow_tree(int balls, const std::vector<Tie>& ties, float opposite_factor)
{
    const int outside = balls;
    DisjointSets pieces(std::size_t(balls) + 1);
    std::vector<int> used, first(std::size_t(balls) + 2, 0);
    for (const int i : sort_by_weight(ties, opposite_factor))
        if (pieces.join(ties[i].a, ties[i].b))
        {
            used.push_back(i);
            ++first[ties[i].a + 1];
            ++first[ties[i].b + 1];
        }
    for (int b = 0; b <= balls; ++b)
        first[b + 1] += first[b];
    std::vector<int> next(first.begin(), first.end() - 1), incident(2 * used.size());
    for (const int i : used)
    {
        incident[next[ties[i].a]++] = i;
        incident[next[ties[i].b]++] = i;
    }

    Tree tree;
    tree.node_of_ball.assign(std::size_t(balls) + 1, -1);
    tree.node_of_ball[outside] = 0;
    tree.ball_of_node = {outside};
    tree.parent = {-1};
    tree.side = {1};
    for (int node = 0; node < tree.size(); ++node)
    {
        const int ball = tree.ball_of_node[node];
        for (int k = first[ball]; k < first[ball + 1]; ++k)
        {
            const Tie& tie = ties[incident[k]];
            const int other = tie.a == ball ? tie.b : tie.a;
            if (tree.node_of_ball[other] >= 0)
                continue;
            tree.node_of_ball[other] = tree.size();
            tree.ball_of_node.push_back(other);
            tree.parent.push_back(node);
            tree.side.push_back(std::int8_t(tie.opposite ? -tree.side[node] : tree.side[node]));
        }
    }

    std::vector<int> weight(tree.ball_of_node.size(), 1), heaviest(tree.ball_of_node.size(), -1);
    for (int node = tree.size() - 1; node > 0; --node)
    {
        const int up = tree.parent[node];
        weight[up] += weight[node];
        if (heaviest[up] < 0 || weight[node] > weight[heaviest[up]])
            heaviest[up] = node;
    }
    tree.path.resize(tree.ball_of_node.size());
    for (int node = 0; node < tree.size(); ++node)
        tree.path[node] = node > 0 && heaviest[tree.parent[node]] == node ? tree.path[tree.parent[node]] : node;
    return tree;
}

/// A tie between nodes of the tree.
struct Link
{
    int a, b, ancestor;
    float weight;
    bool opposite;
};

bool violates(const Link& link, const std::vector<std::int8_t>& side)
{
    return (side[link.a] != side[link.b]) != link.opposite;
}

/// Weight that turning over the subtree of each node would add: that of the satisfied ties that leave it, less that of
/// the violated ones.
std::vector<double> weigh_subtrees(const Tree& tree, const std::vector<Link>& links)
{
    std::vector<double> added(tree.ball_of_node.size(), 0);
    for (const Link& link : links)
    {
        const double change = violates(link, tree.side) ? -link.weight : link.weight;
        added[link.a] += change;
        added[link.b] += change;
        added[link.ancestor] -= 2 * change;
    }
    for (int node = tree.size() - 1; node > 0; --node)
        added[tree.parent[node]] += added[node];
    return added;
}

/// Per node the top of the subtree in which it lies, of those subtrees, none within another, that gain most in sum;
/// -1 in none.
std::vector<int> choose_subtrees(const Tree& tree, const std::vector<double>& added)
{
    std::vector<double> least(added.size(), 0);
    for (int node = tree.size() - 1; node > 0; --node)
    {
        least[node] = std::min(added[node], least[node]);
        least[tree.parent[node]] += least[node];
    }
    std::vector<int> top(added.size(), -1);
    for (int node = 1; node < tree.size(); ++node)
        if (top[tree.parent[node]] >= 0)
            top[node] = top[tree.parent[node]];
        else if (added[node] < 0 && added[node] <= least[node])
            top[node] = node;
    return top;
}

/// Turns subtrees over where that lowers the violated weight; \returns whether any did.
bool turn_subtrees(Tree& tree, const std::vector<Link>& links)
{
    const std::vector<double> added = weigh_subtrees(tree, links);
    const std::vector<int> top = choose_subtrees(tree, added);
    // Subtrees with ties between them may not gain together what each gains alone: then only the best of them turns.
    DisjointSets pieces(top.size());
    for (const Link& link : links)
        if (top[link.a] >= 0 && top[link.b] >= 0)
            pieces.join(link.a, link.b);
    std::vector<double> together(top.size(), 0);
    for (const Link& link : links)
        if ((top[link.a] >= 0) != (top[link.b] >= 0))
            together[pieces.find(top[link.a] >= 0 ? link.a : link.b)] +=
                violates(link, tree.side) ? -link.weight : link.weight;
    std::vector<int> best(top.size(), -1);
    for (int node = 1; node < tree.size(); ++node)
        if (top[node] == node)
        {
            int& b = best[pieces.find(node)];
            if (b < 0 || added[node] < added[b])
                b = node;
        }
    bool any = false;
    for (int node = 1; node < tree.size(); ++node)
    {
        if (top[node] < 0)
            continue;
        const int piece = pieces.find(node);
        if (together[piece] < added[best[piece]] || top[node] == best[piece])
        {
            tree.side[node] = std::int8_t(-tree.side[node]);
            any = true;
        }
    }
    return any;
}

/// \param report asked now and then whether to go on: of how much is done.
BallLabels label_from(float opposite_factor, int balls, const std::vector<Tie>& ties,
                      const std::function<void(double fraction)>& report)
{
    report(0);
    Tree tree = grow_tree(balls, ties, opposite_factor);
    report(0.4);
    std::vector<Link> links;
    links.reserve(ties.size());
    for (const Tie& tie : ties)
    {
        const int a = tree.node_of_ball[tie.a], b = tree.node_of_ball[tie.b];
        // What no tie links to the outside weighs nothing.
        links.push_back(a < 0 ? Link{0, 0, 0, 0, false}
                              : Link{a, b, tree.lowest_common_ancestor(a, b), tie.weight, tie.opposite});
    }
    for (int round = 0; round < most_rounds; ++round)
    {
        report(0.7 + 0.3 * round / most_rounds);
        if (!turn_subtrees(tree, links))
            break;
    }

    BallLabels labels;
    labels.side.assign(balls, -1);
    for (int node = 1; node < tree.size(); ++node)
        labels.side[tree.ball_of_node[node]] = tree.side[node];
    double total = 0, wrong = 0;
    for (const Link& link : links)
    {
        total += link.weight;
        if (violates(link, tree.side))
            wrong += link.weight;
    }
    labels.contradicted = total > 0 ? wrong / total : 0;
    return labels;
}

} // namespace

BallLabels label_balls(int balls, const std::vector<Tie>& ties, int threads, const Progress& progress)
{
    constexpr float trusting = 1.5f;
    BallLabels plain, other;
    std::atomic<bool> is_stopped{false};
    parallel_invoke(
        threads,
        [&]
        {
            try
            {
                plain = label_from(1, balls, ties, [&](double fraction) { progress.report(fraction); });
            }
            catch (...)
            {
                is_stopped = true;
                throw;
            }
        },
        [&]
        {
            other = label_from(trusting, balls, ties,
                               [&](double)
                               {
                                   if (is_stopped)
                                       throw Cancelled();
                               });
        });
    return other.contradicted < plain.contradicted ? other : plain;
}

} // namespace recon
