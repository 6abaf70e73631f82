#include <recon/crust_repair.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <unordered_map>

namespace recon
{
namespace
{

Side opposite(Side side) { return side == Side::inner ? Side::outer : Side::inner; }

/// Pieces into which the neighbours of a ball fall, by side, connected along the edges of its link (a sphere).
class Link
{
public:
    Link(const Triangulation& regular, const CellsAtVertices& at, int ball, const std::vector<Side>& labels)
    {
        for (int k = at.first[ball]; k < at.first[ball + 1]; ++k)
        {
            std::array<int, 3> corners;
            int count = 0;
            for (const int v : regular.cells[at.cell[k]].vertices)
                if (v != ball && v != Triangulation::infinite)
                    corners[count++] = number_of(v);
            for (int i = 1; i < count; ++i)
                for (int j = 0; j < i; ++j)
                    if (labels[balls_[corners[i]]] == labels[balls_[corners[j]]])
                        parent_[root(corners[i])] = root(corners[j]);
        }
    }
    /// One ball of each piece on `side`.
    std::vector<int> pieces(Side side, const std::vector<Side>& labels)
    {
        std::vector<int> result;
        for (int i = 0; i < int(balls_.size()); ++i)
            if (root(i) == i && labels[balls_[i]] == side)
                result.push_back(balls_[i]);
        return result;
    }

private:
    int number_of(int ball)
    {
        const auto found = std::find(balls_.begin(), balls_.end(), ball);
        if (found != balls_.end())
            return int(found - balls_.begin());
        balls_.push_back(ball);
        parent_.push_back(int(parent_.size()));
        return int(balls_.size()) - 1;
    }
    int root(int i)
    {
        while (parent_[i] != i)
            i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    std::vector<int> balls_, parent_;
};

/// Whether the balls `seeds`, all on one side, are connected through that side without passing `excluded`. Searches from all
/// of them in turn, so that it ends as soon as the smallest region is exhausted.
bool are_connected_without(int excluded, const std::vector<int>& seeds, const BallNeighbours& neighbours,
                           const std::vector<Side>& labels)
{
    const Side side = labels[seeds.front()];
    std::vector<int> parent(seeds.size());
    std::vector<std::vector<int>> frontier(seeds.size());
    std::unordered_map<int, int> region;
    int separate = int(seeds.size());
    const auto root = [&](int i)
    {
        while (parent[i] != i)
            i = parent[i];
        return i;
    };
    for (int i = 0; i < int(seeds.size()); ++i)
    {
        parent[i] = i;
        frontier[i] = {seeds[i]};
        region[seeds[i]] = i;
    }
    std::vector<int> next;
    while (separate > 1)
        for (int i = 0; i < int(seeds.size()) && separate > 1; ++i)
        {
            if (parent[i] != i)
                continue;
            if (frontier[i].empty())
                return false;
            next.clear();
            for (const int ball : frontier[i])
                for (int k = neighbours.first[ball]; k < neighbours.first[ball + 1]; ++k)
                {
                    const int other = neighbours.ball[k];
                    if (other == excluded || labels[other] != side)
                        continue;
                    const auto inserted = region.emplace(other, i);
                    if (inserted.second)
                        next.push_back(other);
                    else if (const int met = root(inserted.first->second); met != i)
                    {
                        // The merged region goes on from both frontiers; i stays its representative.
                        parent[met] = i;
                        next.insert(next.end(), frontier[met].begin(), frontier[met].end());
                        --separate;
                    }
                }
            frontier[i].swap(next);
        }
    return true;
}

} // namespace

BallNeighbours::BallNeighbours(const Triangulation& regular, int ball_count)
{
    // Each edge once from every cell at it, both ways; then sorted and unique per row.
    first.assign(std::size_t(ball_count) + 1, 0);
    const auto for_each_pair = [&](auto&& act)
    {
        for (const auto& cell : regular.cells)
            for (int i = 0; i < 4; ++i)
                for (int j = 0; j < 4; ++j)
                    if (i != j && cell.vertices[i] != Triangulation::infinite && cell.vertices[j] != Triangulation::infinite)
                        act(cell.vertices[i], cell.vertices[j]);
    };
    for_each_pair([&](int a, int) { ++first[a + 1]; });
    for (int i = 0; i < ball_count; ++i)
        first[i + 1] += first[i];
    ball.resize(std::size_t(first.back()));
    std::vector<int> next(first.begin(), first.end() - 1);
    for_each_pair([&](int a, int b) { ball[next[a]++] = b; });
    int write = 0;
    for (int i = 0; i < ball_count; ++i)
    {
        const auto begin = ball.begin() + first[i], end = ball.begin() + next[i];
        std::sort(begin, end);
        const auto last = std::unique(begin, end);
        first[i] = write;
        write = int(std::move(begin, last, ball.begin() + write) - ball.begin());
    }
    first[ball_count] = write;
    ball.resize(std::size_t(write));
}

int absorb_islands(const BallNeighbours& neighbours, const std::vector<char>& is_root, double share, std::vector<Side>& labels)
{
    const int n = int(labels.size());
    std::vector<int> component(std::size_t(n), -1);
    struct Component
    {
        Side side;
        int size;
        bool has_root;
    };
    std::vector<Component> components;
    std::vector<int> stack;
    for (int seed = 0; seed < n; ++seed)
    {
        if (component[seed] >= 0 || neighbours.first[seed] == neighbours.first[seed + 1])
            continue;
        const int number = int(components.size());
        components.push_back({labels[seed], 0, false});
        component[seed] = number;
        stack.push_back(seed);
        while (!stack.empty())
        {
            const int ball = stack.back();
            stack.pop_back();
            ++components[number].size;
            components[number].has_root |= is_root[ball] != 0;
            for (int k = neighbours.first[ball]; k < neighbours.first[ball + 1]; ++k)
            {
                const int other = neighbours.ball[k];
                if (component[other] < 0 && labels[other] == labels[ball])
                {
                    component[other] = number;
                    stack.push_back(other);
                }
            }
        }
    }
    int largest = 0;
    for (const Component& c : components)
        if (c.side == Side::inner)
            largest = std::max(largest, c.size);
    int turned = 0;
    for (int i = 0; i < n; ++i)
        if (component[i] >= 0)
        {
            const Component& c = components[component[i]];
            if (!c.has_root && c.size < share * largest)
            {
                labels[i] = opposite(labels[i]);
                ++turned;
            }
        }
    return turned;
}

int cut_handles(const Triangulation& regular, const BallNeighbours& neighbours, const std::vector<char>& is_root,
                const std::vector<char>& is_small, const std::vector<double>& margins, const HandleRepairOptions& options,
                std::vector<Side>& labels)
{
    const int n = int(labels.size());
    const CellsAtVertices at = list_cells_at_vertices(regular, n);
    std::vector<int> candidates;
    for (int i = 0; i < n; ++i)
        if (!is_root[i] && is_small[i] && margins[i] < options.highest_margin && at.first[i] < at.first[i + 1])
            candidates.push_back(i);
    std::sort(candidates.begin(), candidates.end(),
              [&](int a, int b) { return margins[a] != margins[b] ? margins[a] < margins[b] : a < b; });
    int total = 0;
    for (int round = 0; round < options.rounds; ++round)
    {
        int turned = 0;
        for (const int ball : candidates)
        {
            const Side side = labels[ball];
            bool on_interface = false;
            for (int k = neighbours.first[ball]; k < neighbours.first[ball + 1]; ++k)
                on_interface |= labels[neighbours.ball[k]] != side;
            if (!on_interface)
                continue;
            Link link(regular, at, ball, labels);
            const std::vector<int> own = link.pieces(side, labels);
            if (own.size() < 2 || own.size() <= link.pieces(opposite(side), labels).size())
                continue;
            if (!are_connected_without(ball, own, neighbours, labels))
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
