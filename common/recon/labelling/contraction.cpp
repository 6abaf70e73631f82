#include <recon/labelling/contraction.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>

namespace recon
{
namespace
{

/// The graph between clusters, each named by one of its nodes: at most one weight for two of them. Most have few
/// neighbours, and their lists are searched; of two that have many a table says where their weight is.
class ClusterGraph
{
public:
    /// \param pairs each at most once.
    ClusterGraph(int nodes, std::vector<SignedEdge> pairs) : pairs_(std::move(pairs)), links_(std::size_t(nodes))
    {
        std::vector<std::size_t> degrees(std::size_t(nodes), 0);
        for (const SignedEdge& pair : pairs_)
        {
            ++degrees[std::size_t(pair.a)];
            ++degrees[std::size_t(pair.b)];
        }
        for (std::size_t i = 0; i < degrees.size(); ++i)
            links_[i].reserve(degrees[i]);
        for (std::size_t place = 0; place < pairs_.size(); ++place)
        {
            append(pairs_[place].a, pairs_[place].b, int(place));
            append(pairs_[place].b, pairs_[place].a, int(place));
        }
    }
    /// Weight of the pair, null if it has none or one of them is no cluster any more.
    const double* find_weight(int a, int b) const
    {
        const int place = find(a, b);
        return place < 0 ? nullptr : &pairs_[std::size_t(place)].weight;
    }
    /// What it takes to merge it into another [count].
    std::size_t count_links(int cluster) const { return links_[std::size_t(cluster)].size(); }

    /// Moves the weights of `gone` to `keep`, turned over if `turns`. \param changed is called with each cluster whose
    /// weight with `keep` is another now, and that weight.
    template <class Changed>
    void merge(int gone, int keep, bool turns, const Changed& changed)
    {
        const std::vector<Link> moving = std::exchange(links_[std::size_t(gone)], {});
        for (const Link& link : moving)
        {
            SignedEdge& pair = pairs_[std::size_t(link.place)];
            if (pair.a == dead)
                continue;
            const int other = pair.a == gone ? pair.b : pair.a;
            const double moved = turns ? -pair.weight : pair.weight;
            const int present = other == keep ? -1 : find(keep, other);
            if (other != keep && present < 0)
            {
                pair = {keep, other, moved};
                rename(other, link.place, keep);
                append(keep, other, link.place);
                changed(other, moved);
                continue;
            }
            drop(other, link.place);
            pair.a = dead;
            if (present >= 0)
                changed(other, pairs_[std::size_t(present)].weight += moved);
        }
    }

private:
    static constexpr int dead = -1;
    static constexpr std::size_t many = 64;

    struct Link
    {
        int other; ///< Of a cluster with many neighbours: as it was called when the link was made.
        int place; ///< Of the pair, which may be dead if there are many.
    };

    static std::uint64_t key_of(int a, int b)
    {
        return (std::uint64_t(std::uint32_t(std::min(a, b))) << 32) | std::uint32_t(std::max(a, b));
    }
    bool has_many(int cluster) const { return links_[std::size_t(cluster)].size() >= many; }

    int find(int a, int b) const
    {
        if (has_many(a) && has_many(b))
        {
            const auto found = between_many_.find(key_of(a, b));
            return found == between_many_.end() ? -1 : found->second;
        }
        const bool is_first = links_[std::size_t(a)].size() < links_[std::size_t(b)].size();
        const int other = is_first ? b : a;
        for (const Link& link : links_[std::size_t(is_first ? a : b)])
            if (link.other == other)
                return link.place;
        return -1;
    }
    void append(int cluster, int other, int place)
    {
        std::vector<Link>& links = links_[std::size_t(cluster)];
        links.push_back({other, place});
        if (links.size() == many)
            for (const Link& link : links)
                tabulate(cluster, link);
        else if (links.size() > many)
            tabulate(cluster, links.back());
    }
    void tabulate(int cluster, const Link& link)
    {
        if (has_many(link.other))
            between_many_.emplace(key_of(cluster, link.other), link.place);
    }
    void rename(int cluster, int place, int other)
    {
        if (!has_many(cluster))
            find_link(cluster, place)->other = other;
    }
    void drop(int cluster, int place)
    {
        if (has_many(cluster))
            return;
        std::vector<Link>& links = links_[std::size_t(cluster)];
        *find_link(cluster, place) = links.back();
        links.pop_back();
    }
    std::vector<Link>::iterator find_link(int cluster, int place)
    {
        std::vector<Link>& links = links_[std::size_t(cluster)];
        return std::find_if(links.begin(), links.end(), [&](const Link& link) { return link.place == place; });
    }

    std::vector<SignedEdge> pairs_;
    std::vector<std::vector<Link>> links_;
    std::unordered_map<std::uint64_t, int> between_many_; ///< Place of the pair.
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

/// \param edges sorted by their ends.
void add_up_parallel(std::vector<SignedEdge>& edges)
{
    std::size_t count = 0;
    for (std::size_t i = 0; i < edges.size(); ++count)
    {
        SignedEdge sum = {edges[i].a, edges[i].b, 0};
        for (; i < edges.size() && edges[i].a == sum.a && edges[i].b == sum.b; ++i)
            sum.weight += edges[i].weight;
        edges[count] = sum;
    }
    edges.resize(count);
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

/// Hands out the strongest candidate first, and none that is outdated. Only the strongest are in a heap that is small
/// enough for the caches; of the others most are outdated when their turn comes.
class CandidateQueue
{
public:
    explicit CandidateQueue(std::vector<Candidate> candidates) : weaker_(std::move(candidates)) {}

    void push(const Candidate& candidate)
    {
        if (candidate < weakest_)
            weaker_.push_back(candidate);
        else
        {
            heap_.push_back(candidate);
            std::push_heap(heap_.begin(), heap_.end());
        }
    }
    /// \returns false if there is none.
    template <class IsOutdated>
    bool pop(Candidate& strongest, const IsOutdated& is_outdated)
    {
        do
        {
            if (heap_.empty())
                refill(is_outdated);
            if (heap_.empty())
                return false;
            std::pop_heap(heap_.begin(), heap_.end());
            strongest = heap_.back();
            heap_.pop_back();
        } while (is_outdated(strongest));
        return true;
    }

private:
    template <class IsOutdated>
    void refill(const IsOutdated& is_outdated)
    {
        weaker_.erase(std::remove_if(weaker_.begin(), weaker_.end(), is_outdated), weaker_.end());
        if (weaker_.empty())
            return;
        const std::size_t count = std::max(weaker_.size() / share, std::min(weaker_.size(), fewest));
        const auto first = weaker_.end() - std::ptrdiff_t(count);
        std::nth_element(weaker_.begin(), first, weaker_.end());
        weakest_ = *first;
        heap_.assign(first, weaker_.end());
        weaker_.erase(first, weaker_.end());
        std::make_heap(heap_.begin(), heap_.end());
    }

    static constexpr std::size_t share = 16, fewest = 4096;
    std::vector<Candidate> heap_, weaker_;
    Candidate weakest_ = {}; ///< Of those that the heap was last filled with.
};

} // namespace

std::vector<Side> contract(const SignedGraph& graph, ParityForest forest, int root)
{
    const int n = graph.nodes;

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
    add_up_parallel(sorted);
    std::vector<Candidate> candidates;
    candidates.reserve(sorted.size());
    for (const SignedEdge& e : sorted)
        candidates.push_back({std::abs(e.weight), e.a, e.b});
    ClusterGraph clusters(n, std::move(sorted));
    CandidateQueue queue(std::move(candidates));
    const auto is_outdated = [&](const Candidate& c)
    {
        const double* weight = clusters.find_weight(c.a, c.b);
        return !weight || std::abs(*weight) != c.strength || c.strength == 0;
    };
    Candidate top;
    while (queue.pop(top, is_outdated))
    {
        const bool turns = *clusters.find_weight(top.a, top.b) < 0,
                   a_has_more = clusters.count_links(top.a) >= clusters.count_links(top.b);
        const int keep = a_has_more ? top.a : top.b, gone = a_has_more ? top.b : top.a;
        forest.hang(gone, keep, turns);
        clusters.merge(gone, keep, turns,
                       [&](int other, double sum) {
                           queue.push({std::abs(sum), std::min(keep, other), std::max(keep, other)});
                       });
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
