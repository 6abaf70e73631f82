#include <recon/labelling/crust_repair.h>

#include <recon/disjoint_sets.h>
#include <recon/labelling/ball_link.h>

#include <algorithm>
#include <array>
#include <queue>
#include <unordered_map>
#include <utility>

namespace recon
{
namespace
{

/// Whether the balls `seeds`, all on one side, are connected through that side without passing `excluded`. Searches
/// from all of them in turn, so that it ends as soon as the smallest region is exhausted.
bool are_connected_without(int excluded, const std::vector<int>& seeds, const Triangulation& regular,
                           const CellsAtVertices& at, const std::vector<Side>& labels)
{
    const Side side = labels[seeds.front()];
    DisjointSets merged(seeds.size());
    std::vector<std::vector<int>> frontier(seeds.size());
    std::unordered_map<int, int> region;
    int separate = int(seeds.size());
    for (int i = 0; i < int(seeds.size()); ++i)
    {
        frontier[i] = {seeds[i]};
        region[seeds[i]] = i;
    }
    std::vector<int> next;
    while (separate > 1)
        for (int i = 0; i < int(seeds.size()) && separate > 1; ++i)
        {
            if (merged.find(i) != i)
                continue;
            if (frontier[i].empty())
                return false;
            next.clear();
            for (const int ball : frontier[i])
                visit_neighbours(regular, at, ball,
                                 [&](int other)
                                 {
                                     if (other == excluded || labels[other] != side)
                                         return;
                                     const auto [place, is_new] = region.emplace(other, i);
                                     if (is_new)
                                         next.push_back(other);
                                     else if (const int met = merged.find(place->second); merged.join(met, i))
                                     {
                                         // The merged region goes on from both frontiers.
                                         next.insert(next.end(), frontier[met].begin(), frontier[met].end());
                                         frontier[met].clear();
                                         --separate;
                                     }
                                 });
            frontier[i].clear();
            frontier[merged.find(i)].swap(next);
        }
    return true;
}

} // namespace

int absorb_islands(const Triangulation& regular, const std::vector<char>& is_root, const std::vector<int>& weight,
                   const std::vector<char>& is_large, double share, std::vector<Side>& labels, int threads)
{
    constexpr int least_body = 30; // noise makes islands of up to 14 with a large ball
    const int n = int(labels.size());
    const std::vector<char> is_visible = mark_vertices(regular, n);
    DisjointSets components = join_neighbours(regular, labels.size(), threads, [&](int v) { return int(labels[v]); });
    std::vector<int> visible(std::size_t(n), 0), size(std::size_t(n), 0);
    std::vector<char> has_root(std::size_t(n), 0), has_large(std::size_t(n), 0);
    int most_visible = 0, largest = 0;
    for (int i = 0; i < n; ++i)
        if (is_visible[i])
        {
            const int component = components.find(i);
            ++visible[component];
            size[component] += weight[i];
            has_root[component] |= is_root[i];
            has_large[component] |= is_large[i];
            if (labels[i] == Side::inner)
            {
                most_visible = std::max(most_visible, visible[component]);
                largest = std::max(largest, size[component]);
            }
        }
    const auto is_island = [&](int component)
    {
        const bool is_body = has_large[component] && size[component] >= least_body;
        return !has_root[component] && !is_body && visible[component] < share * most_visible &&
               size[component] < share * largest;
    };
    std::vector<int> turned;
    for (int i = 0; i < n; ++i)
        if (is_visible[i] && is_island(components.find(i)))
            turned.push_back(i);
    for (const int i : turned)
        labels[i] = opposite(labels[i]);
    return int(turned.size());
}

void spare_bridges(const Triangulation& regular, const std::vector<Side>& labels, const std::vector<double>& margins,
                   double share, std::vector<int>& doubtful, int threads)
{
    const std::size_t n = labels.size();
    std::vector<char> is_doubtful(n, 0);
    for (const int ball : doubtful)
        is_doubtful[ball] = 1;
    // Of the inside without its doubtful balls.
    DisjointSets parts = join_neighbours(regular, n, threads,
                                         [&](int v) { return labels[v] == Side::inner && !is_doubtful[v] ? 0 : -1; });
    std::vector<int> size(n, 0);
    for (std::size_t i = 0; i < n; ++i)
        ++size[parts.find(int(i))];
    const int largest = int(std::max_element(size.begin(), size.end()) - size.begin());
    std::vector<char> waits(n, 0); // large parts that are not yet joined
    int waiting = 0;
    for (std::size_t i = 0; i < n; ++i)
        if (int(i) != largest && size[i] > 1 && size[i] >= share * size[largest])
        {
            waits[i] = 1;
            ++waiting;
        }
    if (waiting == 0)
        return;

    // Prim's walk from the largest part through doubtful balls, highest margin first.
    const CellsAtVertices at = list_cells_at_vertices(regular, int(n), threads);
    std::vector<std::vector<int>> members(n);
    for (std::size_t i = 0; i < n; ++i)
        if (const int part = parts.find(int(i)); waits[part] || part == largest)
            members[part].push_back(int(i));
    std::vector<int> from(n, -1);
    std::vector<char> is_met(n, 0);
    std::priority_queue<std::pair<double, int>> queue; // of equal margins the lowest index
    const auto meet = [&](int ball, int origin, double margin)
    {
        if (is_met[ball])
            return;
        is_met[ball] = 1;
        from[ball] = origin;
        queue.emplace(margin, -ball);
    };
    const auto meet_part = [&](int part)
    {
        for (const int ball : members[part])
            meet(ball, -1, 2); // before all others: margins are at most 1
    };
    meet_part(largest);
    while (!queue.empty() && waiting > 0)
    {
        const int ball = -queue.top().second;
        queue.pop();
        visit_neighbours(regular, at, ball,
                         [&](int other)
                         {
                             if (labels[other] != Side::inner || is_met[other])
                                 return;
                             const int part = parts.find(other);
                             if (is_doubtful[other])
                                 meet(other, ball, margins[other]);
                             else if (waits[part])
                             {
                                 waits[part] = 0;
                                 --waiting;
                                 for (int bridge = ball; bridge >= 0; bridge = from[bridge])
                                     is_doubtful[bridge] = 0;
                                 meet_part(part);
                             }
                         });
    }
    doubtful.erase(std::remove_if(doubtful.begin(), doubtful.end(), [&](int ball) { return !is_doubtful[ball]; }),
                   doubtful.end());
}

int cut_handles(const Triangulation& regular, const std::vector<char>& is_root, const std::vector<char>& is_small,
                const std::vector<double>& margins, std::vector<Side>& labels, int threads)
{
    constexpr int rounds = 5;
    const int n = int(labels.size());
    std::vector<int> candidates;
    for (int i = 0; i < n; ++i)
        if (!is_root[i] && is_small[i] && margins[i] < doubtful_below)
            candidates.push_back(i);
    std::sort(candidates.begin(), candidates.end(),
              [&](int a, int b) { return margins[a] != margins[b] ? margins[a] < margins[b] : a < b; });
    const CellsAtVertices at = list_cells_at_vertices(regular, n, threads);
    BallLink link(labels.size());
    int total = 0;
    for (int round = 0; round < rounds; ++round)
    {
        int turned = 0;
        for (const int ball : candidates)
        {
            const Side side = labels[ball];
            bool on_interface = false;
            visit_neighbours(regular, at, ball, [&](int other) { on_interface |= labels[other] != side; });
            if (!on_interface)
                continue;
            link.build(regular, at, ball, labels);
            const std::vector<int> own = link.pieces(side);
            if (own.size() < 2 || int(own.size()) <= link.count_pieces(opposite(side)))
                continue;
            if (!are_connected_without(ball, own, regular, at, labels))
                continue;
            labels[ball] = opposite(side);
            ++turned;
        }
        total += turned;
        if (turned == 0)
            break;
    }
    return total;
}

} // namespace recon
