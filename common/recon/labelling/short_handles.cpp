#include <recon/labelling/short_handles.h>

#include <recon/disjoint_sets.h>
#include <recon/labelling/ball_link.h>
#include <recon/labelling/crust_repair.h>
#include <recon/labelling/ring_search.h>
#include <recon/parallel.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <queue>
#include <utility>

namespace recon
{
namespace
{

/// Balls of `side` that stay out when the side grows from those that are not doubtful, highest margin first, and closes
/// no ring more than it fills.
std::vector<int> find_ring_closers(const Triangulation& regular, const CellsAtVertices& at, Side side,
                                   const std::vector<char>& is_doubtful, const std::vector<double>& margins,
                                   std::vector<Side> labels)
{
    const int n = int(labels.size());
    std::vector<char> waits(std::size_t(n), 0);
    std::vector<int> candidates;
    for (int i = 0; i < n; ++i)
        if (is_doubtful[i] && labels[i] == side && at.first[i] < at.first[i + 1])
        {
            candidates.push_back(i);
            waits[i] = 1;
        }
    if (candidates.empty())
        return candidates;
    for (const int i : candidates)
        labels[i] = opposite(side);
    DisjointSets components =
        join_neighbours(regular, labels.size(), 1, [&](int v) { return labels[v] == side ? 0 : -1; });

    std::priority_queue<std::pair<double, int>> queue; // highest margin, then lowest index
    std::vector<char> is_queued(std::size_t(n), 0);
    const auto enqueue = [&](int ball)
    {
        if (waits[ball] && !is_queued[ball])
        {
            queue.emplace(margins[ball], -ball);
            is_queued[ball] = 1;
        }
    };
    for (const int i : candidates)
        enqueue(i);
    BallLink link(labels.size());
    while (!queue.empty())
    {
        const int ball = -queue.top().second;
        queue.pop();
        is_queued[ball] = 0;
        link.build(regular, at, ball, labels);
        std::vector<int> own = link.pieces(side);
        if (own.empty())
            continue; // until a neighbour arrives
        const int pieces = int(own.size()), others = link.count_pieces(opposite(side));
        for (int& piece : own)
            piece = components.find(piece);
        std::sort(own.begin(), own.end());
        const int rings = pieces - int(std::unique(own.begin(), own.end()) - own.begin());
        if (rings > std::max(0, others - 1))
            continue;
        waits[ball] = 0;
        labels[ball] = side;
        for (const int other : link.balls())
        {
            if (labels[other] == side)
                components.join(other, ball);
            enqueue(other); // what it waited for may have come
        }
    }
    candidates.erase(std::remove_if(candidates.begin(), candidates.end(), [&](int i) { return !waits[i]; }),
                     candidates.end());
    return candidates;
}

/// The edges of some balls: what speaks for and against turning them.
class Evidence
{
public:
    /// \param is_listed per ball: whether its edges are wanted.
    Evidence(const SignedGraph& graph, const std::vector<char>& is_listed) : is_in_(is_listed.size(), 0)
    {
        first_.assign(is_listed.size() + 1, 0);
        for (const SignedEdge& e : graph.edges)
        {
            first_[e.a + 1] += is_listed[e.a];
            first_[e.b + 1] += is_listed[e.b];
        }
        std::partial_sum(first_.begin(), first_.end(), first_.begin());
        edges_.resize(std::size_t(first_.back()));
        std::vector<int> next(first_.begin(), first_.end() - 1);
        for (const SignedEdge& e : graph.edges)
        {
            if (is_listed[e.a])
                edges_[next[e.a]++] = {e.b, e.weight};
            if (is_listed[e.b])
                edges_[next[e.b]++] = {e.a, e.weight};
        }
    }
    /// Kept less violated weight of the edges that leave the set: by how much turning it contradicts more.
    double of(const std::vector<int>& set, const std::vector<Side>& labels)
    {
        for (const int ball : set)
            is_in_[ball] = 1;
        double sum = 0;
        for (const int ball : set)
            for (int k = first_[ball]; k < first_[ball + 1]; ++k)
                if (!is_in_[edges_[k].ball])
                    sum += labels[edges_[k].ball] == labels[ball] ? edges_[k].weight : -edges_[k].weight;
        for (const int ball : set)
            is_in_[ball] = 0;
        return sum;
    }

private:
    struct Edge
    {
        int ball;
        double weight;
    };
    std::vector<int> first_;
    std::vector<Edge> edges_;
    std::vector<char> is_in_;
};

/// Connected sets of the balls.
std::vector<std::vector<int>> group(const std::vector<int>& balls, const Triangulation& regular,
                                    const CellsAtVertices& at)
{
    std::vector<char> is_waiting(at.first.size(), 0);
    for (const int ball : balls)
        is_waiting[ball] = 1;
    std::vector<std::vector<int>> groups;
    for (const int seed : balls)
    {
        if (!is_waiting[seed])
            continue;
        std::vector<int> members = {seed};
        is_waiting[seed] = 0;
        for (std::size_t i = 0; i < members.size(); ++i)
            visit_neighbours(regular, at, members[i],
                             [&](int other)
                             {
                                 if (is_waiting[other])
                                 {
                                     is_waiting[other] = 0;
                                     members.push_back(other);
                                 }
                             });
        groups.push_back(std::move(members));
    }
    return groups;
}

/// By how much turning the ball over changes the Euler characteristic of the surface.
int measure_turn(int ball, BallLink& link, const Triangulation& regular, const CellsAtVertices& at,
                 const std::vector<Side>& labels)
{
    link.build(regular, at, ball, labels);
    return 2 * (link.count_pieces(labels[ball]) - link.count_pieces(opposite(labels[ball])));
}

/// Those balls of a set that have to turn for the gain in Euler characteristic: all turn, then each that need not, and
/// against whose turning there is evidence, turns back. \param gain what turning the result changes the Euler
/// characteristic by. `labels` are as before in the end.
std::vector<int> narrow(std::vector<int> set, Evidence& evidence, BallLink& link, const Triangulation& regular,
                        const CellsAtVertices& at, std::vector<Side>& labels, int& gain)
{
    const Side side = labels[set.front()];
    gain = 0;
    for (const int ball : set)
    {
        gain += measure_turn(ball, link, regular, at, labels);
        labels[ball] = opposite(side);
    }
    for (bool again = true; again;)
    {
        again = false;
        for (const int ball : set)
        {
            if (labels[ball] == side)
                continue;
            const int change = measure_turn(ball, link, regular, at, labels);
            // A ball whose return gains where the whole set gained something would close in an island.
            const bool returns = gain > 0 ? change == 0 && evidence.of({ball}, labels) < 0 : change > 0;
            if (!returns)
                continue;
            labels[ball] = side;
            gain += change;
            again = true;
        }
    }
    std::vector<int> turned;
    for (const int ball : set)
        if (labels[ball] != side)
            turned.push_back(ball);
    for (const int ball : set)
        labels[ball] = side;
    return turned;
}

/// What decides whether a set of balls is turned, beside the evidence for it and its ring.
struct SetMeasures
{
    double scale = 0;     ///< Mean local scale.
    double carried = 0;   ///< Samples that spheres as large as the balls would carry [count].
    double agreement = 0; ///< Mean cosine between normals and its side; large balls count for 0 [-1..1].
};

SetMeasures measure_set(const std::vector<int>& set, Side side, const std::vector<Ball>& balls,
                        const std::vector<double>& scale, const std::function<double(int ball)>& outwardness)
{
    SetMeasures result;
    for (const int b : set)
    {
        const double radius = balls[b].radius / scale[b];
        result.scale += scale[b] / double(set.size());
        result.carried += 24 * radius * radius;
        // The four normals around a large ball say little of all that it fills.
        if (radius < small_below)
            result.agreement += (side == Side::outer ? 1 : -1) * outwardness(b) / double(set.size());
    }
    return result;
}

/// The longest ring with which the set is turned [length].
double find_longest_ring(const SetMeasures& set, double against, const ShortHandleOptions& options)
{
    if (against < options.least_share * set.carried)
        return RingSearch::unbounded;
    double support = options.largest_support;
    if (set.agreement > 0)
        support = std::min(support, options.largest_agreement / (set.agreement * set.agreement));
    return set.scale * (against * options.longest_ring > support ? support / against : options.longest_ring);
}

constexpr std::size_t report_every = 64; // sets

/// Whether each surface between the sides is a sphere.
bool are_spheres(const Triangulation& regular, const std::vector<Side>& labels, int threads)
{
    const int euler = measure_interface_euler(regular, labels, threads);
    if (euler < 2)
        return false;
    // Each surface parts two regions that nothing else joins.
    const std::vector<char> is_visible = mark_vertices(regular, int(labels.size()));
    DisjointSets regions = join_neighbours(regular, labels.size(), threads, [&](int v) { return int(labels[v]); });
    int surfaces = -1;
    for (int i = 0; i < int(labels.size()); ++i)
        surfaces += is_visible[i] && regions.find(i) == i;
    return euler == 2 * surfaces;
}

} // namespace

int measure_interface_euler(const Triangulation& regular, const std::vector<Side>& labels, int threads)
{
    // One vertex per mixed cell, one edge per mixed triangle, one polygon per mixed edge of the triangulation.
    std::atomic<long long> vertices{0}, half_edges{0}, faces{0};
    parallel_chunks(std::size_t(regular.finite_cells), threads, 16384, {},
                    [&](std::size_t begin, std::size_t end)
                    {
                        long long own_vertices = 0, own_half_edges = 0, own_faces = 0;
                        std::vector<int> ring;
                        for (int c = int(begin); c < int(end); ++c)
                        {
                            const auto& v = regular.cells[c].vertices;
                            int inner = 0;
                            for (const int ball : v)
                                inner += labels[ball] == Side::inner;
                            if (inner == 0 || inner == 4)
                                continue;
                            ++own_vertices;
                            own_half_edges += inner == 2 ? 4 : 3;
                            for (int i = 0; i < 4; ++i)
                                for (int j = i + 1; j < 4; ++j)
                                    own_faces += labels[v[i]] != labels[v[j]] && regular.can_be_lowest(c, i, j) &&
                                                 regular.list_ring_from_lowest(c, v[i], v[j], ring);
                        }
                        vertices += own_vertices;
                        half_edges += own_half_edges;
                        faces += own_faces;
                    });
    return int(vertices - half_edges / 2 + faces);
}

int remove_short_handles(const Triangulation& regular, const SignedGraph& graph, const std::vector<Ball>& balls,
                         const std::vector<double>& scale, const std::vector<double>& margins,
                         const std::function<double(int ball)>& outwardness, const ShortHandleOptions& options,
                         std::vector<Side>& labels, const Progress& progress)
{
    if (are_spheres(regular, labels, options.threads))
        return 0; // they have no handles
    const CellsAtVertices at = list_cells_at_vertices(regular, int(labels.size()), options.threads);
    std::vector<char> is_doubtful(labels.size());
    for (std::size_t i = 0; i < labels.size(); ++i)
        is_doubtful[i] = margins[i] < options.highest_margin && !graph.is_root[i];
    RingSearch rings(regular, at, balls);
    BallLink link(labels.size());
    int total = 0;
    for (int round = 0; round < options.rounds; ++round)
    {
        int turned = 0;
        const Progress part = progress.part(double(round) / options.rounds, double(round + 1) / options.rounds);
        part.report(0);
        // Across the handle or through it, whichever goes against less.
        std::vector<std::vector<int>> inner, outer;
        const auto find = [&](Side side)
        { return group(find_ring_closers(regular, at, side, is_doubtful, margins, labels), regular, at); };
        parallel_invoke(
            options.threads, [&] { inner = find(Side::inner); }, [&] { outer = find(Side::outer); });
        part.report(0.5);
        std::vector<char> is_listed(labels.size(), 0);
        for (const auto* sets : {&inner, &outer})
            for (const std::vector<int>& set : *sets)
                for (const int ball : set)
                    is_listed[ball] = 1;
        Evidence evidence(graph, is_listed);
        std::vector<std::pair<double, std::vector<int>>> closers;
        for (auto* sets : {&inner, &outer})
            for (std::vector<int>& set : *sets)
            {
                const double against = evidence.of(set, labels);
                closers.emplace_back(against, std::move(set));
            }
        std::stable_sort(closers.begin(), closers.end(),
                         [](const auto& a, const auto& b) { return a.first < b.first; });
        for (std::size_t k = 0; k < closers.size(); ++k)
        {
            if (k % report_every == 0)
                part.report(0.5 + 0.5 * double(k) / double(closers.size()));
            int gain = 0;
            const std::vector<int> set = narrow(closers[k].second, evidence, link, regular, at, labels, gain);
            if (gain <= 0)
                continue;
            const SetMeasures measures = measure_set(set, labels[set.front()], balls, scale, outwardness);
            // A set may close several handles at once, of which each has its share.
            const double against = evidence.of(set, labels) * 2 / gain;
            const double longest = find_longest_ring(measures, against, options);
            if (!rings.closes_ring(set, labels, longest))
                continue;
            for (const int ball : set)
                labels[ball] = opposite(labels[ball]);
            turned += int(set.size());
        }
        total += turned;
        if (turned == 0)
            break;
    }
    return total;
}

} // namespace recon
