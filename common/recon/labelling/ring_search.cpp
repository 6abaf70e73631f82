#include <recon/labelling/ring_search.h>

#include <recon/disjoint_sets.h>
#include <recon/labelling/ball_link.h>

#include <algorithm>
#include <functional>
#include <queue>
#include <utility>

namespace recon
{

RingSearch::RingSearch(const Triangulation& regular, const CellsAtVertices& at, const std::vector<Ball>& balls)
    : regular_(regular), at_(at), balls_(balls), steps_(balls.size()), distance_(balls.size(), unbounded),
      piece_(balls.size(), -1), is_in_(balls.size(), 0)
{
}

bool RingSearch::closes_ring(const std::vector<int>& set, const std::vector<Side>& labels, double longest)
{
    const Side side = labels[set.front()];
    for (const int b : set)
        is_in_[b] = 1;
    const std::vector<int> seeds = number_pieces(set, side, labels);
    std::vector<int> pieces;
    for (const int b : seeds)
        pieces.push_back(piece_[b]);
    std::sort(pieces.begin(), pieces.end());
    pieces.erase(std::unique(pieces.begin(), pieces.end()), pieces.end());
    const bool result =
        pieces.size() > 1 && (longest == unbounded ? are_joined(seeds, pieces.size(), side, labels)
                                                   : are_near(seeds, std::move(pieces), side, labels, longest));
    for (const int b : set)
        is_in_[b] = 0;
    for (const int b : touched_)
        piece_[b] = -1;
    touched_.clear();
    return result;
}

bool RingSearch::counts(int ball, Side side, const std::vector<Side>& labels) const
{
    return labels[ball] == side && !is_in_[ball];
}

/// Neighbours of the set on its side, numbered by piece of its link in piece_ if there are at least two pieces.
std::vector<int> RingSearch::number_pieces(const std::vector<int>& set, Side side, const std::vector<Side>& labels)
{
    std::vector<int> around;
    for (const int b : set)
        visit_neighbours(regular_, at_, b,
                         [&](int other)
                         {
                             if (counts(other, side, labels) && piece_[other] < 0)
                             {
                                 piece_[other] = int(around.size());
                                 around.push_back(other);
                                 touched_.push_back(other);
                             }
                         });
    DisjointSets pieces(around.size());
    for (const int b : set)
        for (int k = at_.first[b]; k < at_.first[b + 1]; ++k)
        {
            const auto& corners = regular_.cells[at_.cell[k]].vertices;
            for (int i = 1; i < 4; ++i)
                for (int j = 0; j < i; ++j)
                    if (const int a = corners[i], c = corners[j]; a != Triangulation::infinite &&
                                                                  c != Triangulation::infinite &&
                                                                  counts(a, side, labels) && counts(c, side, labels))
                        pieces.join(piece_[a], piece_[c]);
        }
    for (std::size_t i = 0; i < around.size(); ++i)
        piece_[around[i]] = pieces.find(int(i));
    return around;
}

/// To each neighbour of the ball once. Searches cross the same balls again and again.
const std::vector<RingSearch::Step>& RingSearch::steps_from(int ball)
{
    std::vector<Step>& steps = steps_[ball];
    if (!steps.empty())
        return steps;
    std::vector<int> others;
    visit_neighbours(regular_, at_, ball, [&](int other) { others.push_back(other); });
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
    for (const int other : others)
        steps.push_back({other, (balls_[other].centre - balls_[ball].centre).norm()});
    return steps;
}

/// By growing from all pieces at once, until all have met or one can grow no more.
bool RingSearch::are_joined(const std::vector<int>& seeds, std::size_t count, Side side,
                            const std::vector<Side>& labels)
{
    DisjointSets pieces(seeds.size());
    std::vector<int> growing(seeds.size(), 0); // balls from which a piece grows
    for (const int b : seeds)
        ++growing[piece_[b]];
    std::vector<int> queue = seeds;
    for (std::size_t i = 0; i < queue.size(); ++i)
    {
        const int ball = queue[i];
        for (const Step& step : steps_from(ball))
        {
            const int own = pieces.find(piece_[ball]);
            if (!counts(step.ball, side, labels))
                continue;
            if (piece_[step.ball] < 0)
            {
                piece_[step.ball] = own;
                touched_.push_back(step.ball);
                queue.push_back(step.ball);
                ++growing[own];
            }
            else if (const int other = pieces.find(piece_[step.ball]); other != own)
            {
                if (--count == 1)
                    return true;
                pieces.join(own, other);
                growing[pieces.find(own)] = growing[own] + growing[other];
            }
        }
        if (--growing[pieces.find(piece_[ball])] == 0)
            return false;
    }
    return false;
}

/// By Dijkstra's distances from the piece of the first seed. \param missing all pieces.
bool RingSearch::are_near(const std::vector<int>& seeds, std::vector<int> missing, Side side,
                          const std::vector<Side>& labels, double longest)
{
    std::vector<int> reached;
    std::priority_queue<std::pair<double, int>, std::vector<std::pair<double, int>>, std::greater<>> queue;
    const auto reach = [&](int ball, double length)
    {
        if (length <= longest && length < distance_[ball])
        {
            if (distance_[ball] == unbounded)
                reached.push_back(ball);
            distance_[ball] = length;
            queue.emplace(length, ball);
        }
    };
    for (const int b : seeds)
        if (piece_[b] == piece_[seeds.front()])
            reach(b, 0);
    while (!queue.empty() && !missing.empty())
    {
        const auto [length, ball] = queue.top();
        queue.pop();
        if (length > distance_[ball])
            continue;
        if (piece_[ball] >= 0)
            missing.erase(std::remove(missing.begin(), missing.end(), piece_[ball]), missing.end());
        for (const Step& step : steps_from(ball))
            if (counts(step.ball, side, labels))
                reach(step.ball, length + step.length);
    }
    for (const int b : reached)
        distance_[b] = unbounded;
    return missing.empty();
}

} // namespace recon
