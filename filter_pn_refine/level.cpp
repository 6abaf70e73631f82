#include "level.h"

#include <recon/parallel.h>

#include <algorithm>
#include <numeric>

namespace recon::pn
{
namespace
{

void update_leaf(Leaf& leaf, const WorkPoint* points)
{
    leaf.box = Box();
    leaf.largest_radius = 0;
    leaf.is_refined = false;
    for (int i = leaf.begin; i < leaf.end; ++i)
    {
        const WorkPoint& p = points[i];
        leaf.box.minimum = leaf.box.minimum.cwiseMin(p.position);
        leaf.box.maximum = leaf.box.maximum.cwiseMax(p.position);
        // A point that is not refined reaches for nothing.
        if (p.flags & WorkPoint::refined)
        {
            leaf.largest_radius = std::max(leaf.largest_radius, p.radius);
            leaf.is_refined = true;
        }
    }
}

/// Splits points[begin, end) at medians of the widest axis until leaves are small; appends them in order.
void split(WorkPoint* points, int begin, int end, std::vector<Leaf>& leaves)
{
    Leaf leaf;
    leaf.begin = begin;
    leaf.end = end;
    update_leaf(leaf, points);
    if (leaf.size() <= leaf_capacity)
    {
        leaves.push_back(leaf);
        return;
    }
    Eigen::Index axis;
    (leaf.box.maximum - leaf.box.minimum).maxCoeff(&axis);
    const int middle = begin + leaf.size() / 2;
    // Ties by id: nth_element may order equal keys as it likes, and grids are full of them.
    std::nth_element(points + begin, points + middle, points + end,
                     [axis](const WorkPoint& a, const WorkPoint& b)
                     {
                         const double x = a.position[axis], y = b.position[axis];
                         return x < y || (x == y && a.id < b.id);
                     });
    split(points, begin, middle, leaves);
    split(points, middle, end, leaves);
}

struct Node
{
    Box box;
    double radius = 0;
};

/// Squared distance between two boxes.
double box_distance2(const Box& a, const Box& b)
{
    return (a.minimum - b.maximum).cwiseMax(b.minimum - a.maximum).cwiseMax(0.0).squaredNorm();
}

/// Boxes of pairs, pairs of pairs and so on, over a sequence of leaves.
class Pyramid
{
public:
    explicit Pyramid(const std::vector<Leaf>& leaves)
    {
        rows_.emplace_back();
        for (const Leaf& leaf : leaves)
            rows_[0].push_back({leaf.box, leaf.largest_radius});
        while (rows_.back().size() > 1)
        {
            const std::vector<Node>& below = rows_.back();
            std::vector<Node> row((below.size() + 1) / 2);
            for (std::size_t i = 0; i < below.size(); ++i)
            {
                Node& n = row[i / 2];
                n.box.minimum = n.box.minimum.cwiseMin(below[i].box.minimum);
                n.box.maximum = n.box.maximum.cwiseMax(below[i].box.maximum);
                n.radius = std::max(n.radius, below[i].radius);
            }
            rows_.push_back(std::move(row));
        }
    }

    /// Leaves within reach of leaf `self`, ascending.
    void meet(int self, std::vector<int>& found) const
    {
        const Node& own = rows_[0][std::size_t(self)];
        descend(int(rows_.size()) - 1, 0, self, own, found);
    }

private:
    void descend(int row, int i, int self, const Node& own, std::vector<int>& found) const
    {
        const Node& node = rows_[std::size_t(row)][std::size_t(i)];
        const double reach = (own.radius + node.radius) * (1 + 1e-4); // hides the rounding of single precision
        if (box_distance2(own.box, node.box) > reach * reach)
            return;
        if (row == 0)
        {
            if (i != self)
                found.push_back(i);
            return;
        }
        descend(row - 1, 2 * i, self, own, found);
        if (2 * i + 1 < int(rows_[std::size_t(row) - 1].size()))
            descend(row - 1, 2 * i + 1, self, own, found);
    }

    std::vector<std::vector<Node>> rows_;
};

} // namespace

Level make_level(std::vector<WorkPoint> points)
{
    Level level;
    level.points = std::move(points);
    if (!level.points.empty())
        split(level.points.data(), 0, int(level.points.size()), level.leaves);
    return level;
}

Level grow_level(const Level& level, const std::vector<std::vector<Child>>& children,
                 const std::vector<double>& next_radius, double target_radius, int threads, const Progress& progress)
{
    const std::size_t n = level.leaves.size();
    std::vector<int> first(n + 1, 0);
    for (std::size_t i = 0; i < n; ++i)
        first[i + 1] = first[i] + level.leaves[i].size() + int(children[i].size());
    Level next;
    next.points.resize(std::size_t(first[n]));
    constexpr std::size_t grain = 64;
    std::vector<std::vector<Leaf>> parts((n + grain - 1) / grain);
    parallel_chunks(n, threads, grain, progress,
                    [&](std::size_t begin, std::size_t end)
                    {
                        for (std::size_t i = begin; i < end; ++i)
                        {
                            const Leaf& leaf = level.leaves[i];
                            WorkPoint* out = next.points.data() + first[i];
                            for (int j = leaf.begin; j < leaf.end; ++j, ++out)
                            {
                                *out = level.points[std::size_t(j)];
                                out->radius = next_radius[std::size_t(j)];
                            }
                            for (const Child& child : children[i])
                                *out++ = child.point;
                            for (WorkPoint* p = next.points.data() + first[i]; p != out; ++p)
                            {
                                const bool goes_on = !(p->flags & WorkPoint::frozen) && p->radius > target_radius;
                                p->flags = goes_on ? (p->flags | WorkPoint::refined) : (p->flags & ~WorkPoint::refined);
                            }
                            split(next.points.data(), first[i], first[i + 1], parts[begin / grain]);
                        }
                    });
    for (const std::vector<Leaf>& part : parts)
        next.leaves.insert(next.leaves.end(), part.begin(), part.end());
    return next;
}

LeafGraph connect_leaves(const Level& level, int threads, const Progress& progress)
{
    const std::size_t n = level.leaves.size();
    const Pyramid pyramid(level.leaves);
    LeafGraph graph;
    std::vector<int> counts(n, 0);
    constexpr std::size_t grain = 256;
    std::vector<std::vector<int>> parts((n + grain - 1) / grain);
    parallel_chunks(n, threads, grain, progress,
                    [&](std::size_t begin, std::size_t end)
                    {
                        std::vector<int>& part = parts[begin / grain];
                        for (std::size_t i = begin; i < end; ++i)
                        {
                            const std::size_t before = part.size();
                            pyramid.meet(int(i), part);
                            counts[i] = int(part.size() - before);
                        }
                    });
    graph.first.assign(n + 1, 0);
    std::partial_sum(counts.begin(), counts.end(), graph.first.begin() + 1);
    graph.neighbour.reserve(std::size_t(graph.first[n]));
    for (const std::vector<int>& part : parts)
        graph.neighbour.insert(graph.neighbour.end(), part.begin(), part.end());

    std::vector<int> colour(n, -1);
    std::vector<int> taken; // per colour the last leaf that saw it beside itself
    for (std::size_t i = 0; i < n; ++i)
    {
        if (!level.leaves[i].is_refined)
            continue;
        for (int j = graph.first[i]; j < graph.first[i + 1]; ++j)
            if (const int c = colour[std::size_t(graph.neighbour[std::size_t(j)])]; c >= 0)
                taken[std::size_t(c)] = int(i);
        std::size_t c = 0;
        while (c < taken.size() && taken[c] == int(i))
            ++c;
        if (c == taken.size())
        {
            taken.push_back(-1);
            graph.colours.emplace_back();
        }
        colour[i] = int(c);
        graph.colours[c].push_back(int(i));
    }
    return graph;
}

std::vector<int> places_of_ids(const Level& level, int ids)
{
    std::vector<int> places(std::size_t(ids), -1);
    for (std::size_t i = 0; i < level.points.size(); ++i)
        places[std::size_t(level.points[i].id)] = int(i);
    return places;
}

int leaf_of_place(const Level& level, int place)
{
    const auto after = std::upper_bound(level.leaves.begin(), level.leaves.end(), place,
                                        [](int p, const Leaf& leaf) { return p < leaf.begin; });
    return int(after - level.leaves.begin()) - 1;
}

} // namespace recon::pn
