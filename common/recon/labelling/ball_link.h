#pragma once

#include <recon/disjoint_sets.h>
#include <recon/labelling/signed_graph.h>
#include <recon/parallel.h>
#include <recon/triangulation/triangulation.h>

#include <algorithm>
#include <vector>

namespace recon
{

/// Begins to read the cells around a ball, which lie anywhere in memory.
inline void fetch_cells(const Triangulation& regular, const CellsAtVertices& at, int ball)
{
    for (int k = at.first[ball]; k < at.first[ball + 1]; ++k)
        __builtin_prefetch(&regular.cells[at.cell[k]]);
}

/// Calls f(neighbour) for each neighbour of a ball, some more than once.
template <class F>
void visit_neighbours(const Triangulation& regular, const CellsAtVertices& at, int ball, F&& f)
{
    fetch_cells(regular, at, ball);
    for (int k = at.first[ball]; k < at.first[ball + 1]; ++k)
        for (const int other : regular.cells[at.cell[k]].vertices)
            if (other != ball && other != Triangulation::infinite)
                f(other);
}

/// Joins neighbouring balls of one group. \param group_of of a ball: 0 or 1, negative for one that is joined to none.
template <class GroupOf>
DisjointSets join_neighbours(const Triangulation& regular, std::size_t balls, int threads, GroupOf&& group_of)
{
    DisjointSets sets(balls);
    // Balls of one group in a cell are all neighbours: to join each to the first is enough.
    const auto join_in_cell = [&](std::size_t c)
    {
        int first[2] = {-1, -1};
        for (const int v : regular.cells[c].vertices)
        {
            const int group = v == Triangulation::infinite ? -1 : group_of(v);
            if (group < 0)
                continue;
            if (first[group] < 0)
                first[group] = v;
            else
                sets.join(first[group], v);
        }
    };
    parallel_for(regular.cells.size(), threads, {}, join_in_cell, 8192);
    return sets;
}

/// The neighbours of a ball in the dual of a power diagram and the pieces into which they fall by side, connected along
/// the edges of the ball's link (a sphere). With p pieces of the ball's own side and q of the other, giving the ball
/// the other side changes the Euler characteristic of the surface between the sides by 2 (p - q): own and other regions
/// of the link take each other's place, and their Euler characteristics are p - q + 1 and q - p + 1.
class BallLink
{
public:
    /// \param balls of the triangulations to come [count].
    explicit BallLink(std::size_t balls) : number_(balls, none) {}

    /// Replaces the content; `labels` must stay alive.
    void build(const Triangulation& regular, const CellsAtVertices& at, int ball, const std::vector<Side>& labels)
    {
        for (const int old : balls_)
            number_[old] = none;
        balls_.clear();
        parent_.clear();
        labels_ = &labels;
        fetch_cells(regular, at, ball);
        for (int k = at.first[ball]; k < at.first[ball + 1]; ++k)
        {
            // Of one side in a cell all are neighbours: to join each to the first is enough.
            int first[2] = {none, none};
            for (const int v : regular.cells[at.cell[k]].vertices)
                if (v != ball && v != Triangulation::infinite)
                {
                    const int i = number_of(v);
                    int& own = first[labels[v] == Side::inner];
                    if (own == none)
                        own = i;
                    else
                        join(own, i);
                }
        }
    }
    /// One ball of each piece on `side`.
    std::vector<int> pieces(Side side) const
    {
        std::vector<int> result;
        for (std::size_t i = 0; i < balls_.size(); ++i)
            if (parent_[i] == int(i) && (*labels_)[balls_[i]] == side)
                result.push_back(balls_[i]);
        return result;
    }
    int count_pieces(Side side) const
    {
        int count = 0;
        for (std::size_t i = 0; i < balls_.size(); ++i)
            count += parent_[i] == int(i) && (*labels_)[balls_[i]] == side;
        return count;
    }
    const std::vector<int>& balls() const { return balls_; }

private:
    static constexpr int none = -1;

    int number_of(int ball)
    {
        int& number = number_[ball];
        if (number == none)
        {
            number = int(balls_.size());
            balls_.push_back(ball);
            parent_.push_back(number);
        }
        return number;
    }
    int find(int i)
    {
        while (parent_[i] != i)
            i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    /// The lowest of a set represents it.
    void join(int i, int j)
    {
        i = find(i);
        j = find(j);
        parent_[std::max(i, j)] = std::min(i, j);
    }

    const std::vector<Side>* labels_ = nullptr;
    std::vector<int> number_; ///< Per ball its place in the link, or none.
    std::vector<int> balls_;
    std::vector<int> parent_; ///< Per place, of the pieces' union-find.
};

} // namespace recon
