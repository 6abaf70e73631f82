#include "level.h"

#include "kernels.h"

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
    leaf.refined_count = 0;
    leaf.has_creases = false;
    for (int i = leaf.begin; i < leaf.end; ++i)
    {
        const WorkPoint& p = points[i];
        leaf.box.minimum = leaf.box.minimum.cwiseMin(p.position);
        leaf.box.maximum = leaf.box.maximum.cwiseMax(p.position);
        leaf.has_creases |= (p.flags & WorkPoint::crease) != 0;
        // A point that is not refined reaches for nothing.
        if (p.flags & WorkPoint::refined)
        {
            leaf.largest_radius = std::max(leaf.largest_radius, double(p.radius));
            ++leaf.refined_count;
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
    // Grids are full of ties, and nth_element may order equal keys as it likes. Ids follow the input's order, so they
    // decide only between points at one position.
    std::nth_element(points + begin, points + middle, points + end,
                     [axis](const WorkPoint& a, const WorkPoint& b)
                     {
                         if (a.position[axis] != b.position[axis])
                             return a.position[axis] < b.position[axis];
                         for (int k = 0; k < 3; ++k)
                             if (a.position[k] != b.position[k])
                                 return a.position[k] < b.position[k];
                         return a.id < b.id;
                     });
    split(points, begin, middle, leaves);
    split(points, middle, end, leaves);
}

/// Writes the leaf's points in single precision.
void write_rows(Level& level, const Leaf& leaf)
{
    const Point centre = leaf.box.centre();
    for (int i = leaf.begin; i < leaf.end; ++i)
    {
        const WorkPoint& p = level.points[std::size_t(i)];
        const Vector d = p.position - centre;
        for (int axis = 0; axis < 3; ++axis)
        {
            level.rows[std::size_t(axis)][std::size_t(i)] = float(d[axis]);
            level.rows[std::size_t(3 + axis)][std::size_t(i)] = float(p.normal[axis]);
        }
        level.rows[6][std::size_t(i)] = p.radius;
    }
}

void resize_rows(Level& level)
{
    const std::size_t n = level.points.size();
    for (std::unique_ptr<float[]>& row : level.rows)
    {
        row.reset(new float[n + lane_count]);
        std::fill_n(row.get() + n, lane_count, 0.f);
    }
}

/// Makes the children of a leaf in double and appends them.
void make_children(const Level& level, const Growth& growth, const UnitFrame& frame, const Appended& appended,
                   std::size_t leaf, WorkPoint* made)
{
    const LeafChildren& children = growth.children[leaf];
    const int first = growth.first[leaf], n = children.count();
    kernels().finish_children(level.points.data(), children.corners(), n, made, appended.parents + first);
    for (int k = 0; k < n; ++k)
    {
        made[k].flags = WorkPoint::refined;
        for (int corner : children.corners()[k])
            made[k].flags |= level.points[std::size_t(corner)].flags & WorkPoint::near_mouth;
        if (growth.correct)
            growth.correct(children.corners()[k], made[k]);
    }
    for (const auto& [own, number] : children.made())
        made[own] = growth.made[std::size_t(number)];
    const float* radius = children.rows().radius;
    for (int k = 0; k < n; ++k)
    {
        made[k].radius = radius[k];
        made[k].id = growth.first_id + first + k;
        appended.points[first + k] = frame.from_unit(made[k].position);
        appended.normals[first + k] = made[k].normal;
        appended.radii[first + k] = double(radius[k]) * frame.scale();
    }
}

/// Boxes grown by radii: of leaves, of every eight of them, of every eight of those and so on, eight side by side in
/// memory, which compilers turn into vectors.
class Pyramid
{
public:
    explicit Pyramid(const std::vector<Leaf>& leaves)
    {
        std::vector<Node> nodes;
        nodes.reserve(leaves.size());
        for (const Leaf& leaf : leaves)
            // The slack hides the rounding of single precision.
            nodes.push_back({leaf.box, leaf.largest_radius * (1 + 1e-4) + 1e-5 * leaf.box.diagonal()});
        while (true)
        {
            rows_.emplace_back((nodes.size() + width - 1) / width);
            std::vector<Node> above(rows_.back().size());
            for (std::size_t i = 0; i < nodes.size(); ++i)
            {
                BoxBlock& block = rows_.back()[i / width];
                for (std::size_t axis = 0; axis < 3; ++axis)
                {
                    block.minimum[axis][i % width] = nodes[i].box.minimum[Eigen::Index(axis)];
                    block.maximum[axis][i % width] = nodes[i].box.maximum[Eigen::Index(axis)];
                }
                block.radius[i % width] = nodes[i].radius;
                Node& n = above[i / width];
                n.box.minimum = n.box.minimum.cwiseMin(nodes[i].box.minimum);
                n.box.maximum = n.box.maximum.cwiseMax(nodes[i].box.maximum);
                n.radius = std::max(n.radius, nodes[i].radius);
            }
            if (above.size() <= 1)
                return;
            nodes.swap(above);
        }
    }

    /// Leaves within reach of leaf `self`, ascending.
    void meet(int self, std::vector<int>& found) const
    {
        const BoxBlock& block = rows_[0][std::size_t(self) / width];
        Node own;
        const std::size_t lane = std::size_t(self) % width;
        for (std::size_t axis = 0; axis < 3; ++axis)
        {
            own.box.minimum[Eigen::Index(axis)] = block.minimum[axis][lane];
            own.box.maximum[Eigen::Index(axis)] = block.maximum[axis][lane];
        }
        own.radius = block.radius[lane];
        descend(rows_.size() - 1, 0, self, own, found);
    }

private:
    static constexpr std::size_t width = BoxBlock::width;
    struct Node
    {
        Box box;
        double radius = 0;
    };

    void descend(std::size_t row, std::size_t i, int self, const Node& own, std::vector<int>& found) const
    {
        unsigned met =
            kernels().meeting_boxes(rows_[row][i], own.box.minimum.data(), own.box.maximum.data(), own.radius);
        for (std::size_t at = width * i; met != 0; ++at, met >>= 1)
            if (!(met & 1))
                continue;
            else if (row > 0)
                descend(row - 1, at, self, own, found);
            else if (int(at) != self)
                found.push_back(int(at));
    }

    std::vector<std::vector<BoxBlock>> rows_;
};

} // namespace

double squared_distance(const Box& a, const Box& b)
{
    return (a.minimum - b.maximum).cwiseMax(b.minimum - a.maximum).cwiseMax(0.0).squaredNorm();
}

void LeafChildren::reserve(int n)
{
    n = padded(n);
    if (n <= capacity_)
        return;
    std::unique_ptr<float[]> rows(new float[8 * std::size_t(n)]);
    for (std::size_t r = 0; r < 8; ++r)
        std::copy_n(rows_ + r * std::size_t(capacity_), count_, rows.get() + r * std::size_t(n));
    std::unique_ptr<std::array<int, 3>[]> corners(new std::array<int, 3>[std::size_t(n)]);
    std::copy_n(corners_, count_, corners.get());
    own_rows_ = std::move(rows);
    own_corners_ = std::move(corners);
    use(own_rows_.get(), own_corners_.get(), n);
}

std::vector<LeafChildren> ChildrenMemory::lists_for(const Level& level)
{
    std::vector<LeafChildren> lists(level.leaves.size());
    std::size_t block = 0;
    int used = 0; // of the block
    for (std::size_t i = 0; i < lists.size(); ++i)
    {
        if (!level.leaves[i].is_refined())
            continue;
        const int room = padded(2 * level.leaves[i].size());
        if (used + room > block_size)
        {
            ++block;
            used = 0;
        }
        if (block == blocks_.size())
            blocks_.push_back({std::unique_ptr<Line[]>(new Line[8 * block_size / lane_count]),
                               std::unique_ptr<std::array<int, 3>[]>(new std::array<int, 3>[block_size])});
        lists[i].use(blocks_[block].rows[std::size_t(8 * used / lane_count)].values,
                     blocks_[block].corners.get() + used, room);
        used += room;
    }
    return lists;
}

Level make_level(std::vector<WorkPoint> points)
{
    Level level;
    level.points = std::move(points);
    resize_rows(level);
    if (!level.points.empty())
        split(level.points.data(), 0, int(level.points.size()), level.leaves);
    for (const Leaf& leaf : level.leaves)
        write_rows(level, leaf);
    return level;
}

Level grow_level(const Level& level, const Growth& growth, const UnitFrame& frame, const Appended& appended,
                 int threads, const Progress& progress)
{
    const std::size_t n = level.leaves.size();
    Level next;
    next.points.resize(level.points.size() + std::size_t(growth.first[n]));
    resize_rows(next);
    const auto grow_leaf = [&](std::size_t i, std::vector<Leaf>& leaves)
    {
        const Leaf& leaf = level.leaves[i];
        const int begin = leaf.begin + growth.first[i], middle = begin + leaf.size(),
                  end = begin + leaf.size() + growth.first[i + 1] - growth.first[i];
        for (int j = leaf.begin; j < leaf.end; ++j)
        {
            WorkPoint& p = next.points[std::size_t(begin + j - leaf.begin)];
            p = level.points[std::size_t(j)];
            p.radius = growth.next_radius[std::size_t(j)];
        }
        make_children(level, growth, frame, appended, i, next.points.data() + middle);
        for (int j = begin; j < end; ++j)
        {
            WorkPoint& p = next.points[std::size_t(j)];
            const bool goes_on = !(p.flags & WorkPoint::frozen) && double(p.radius) > growth.target_radius;
            p.flags = goes_on ? (p.flags | WorkPoint::refined) : (p.flags & ~WorkPoint::refined);
        }
        const std::size_t before = leaves.size();
        split(next.points.data(), begin, end, leaves);
        for (std::size_t k = before; k < leaves.size(); ++k)
            write_rows(next, leaves[k]);
    };
    next.leaves = parallel_collect<Leaf>(n, threads, progress, grow_leaf, 64);
    return next;
}

void append_children(const Level& level, const Growth& growth, const UnitFrame& frame, const Appended& appended,
                     int threads, const Progress& progress)
{
    parallel_chunks(level.leaves.size(), threads, 64, progress,
                    [&](std::size_t begin, std::size_t end)
                    {
                        std::vector<WorkPoint> made;
                        for (std::size_t i = begin; i < end; ++i)
                        {
                            const auto count = std::size_t(growth.first[i + 1] - growth.first[i]);
                            if (made.size() < count)
                                made.resize(count);
                            make_children(level, growth, frame, appended, i, made.data());
                        }
                    });
}

LeafGraph connect_leaves(const Level& level, int threads, const Progress& progress)
{
    const std::size_t n = level.leaves.size();
    const Pyramid pyramid(level.leaves);
    LeafGraph graph;
    std::vector<int> counts(n, 0);
    graph.neighbour = parallel_collect<int>(
        n, threads, progress,
        [&](std::size_t i, std::vector<int>& met)
        {
            const std::size_t before = met.size();
            pyramid.meet(int(i), met);
            counts[i] = int(met.size() - before);
        },
        32);
    graph.first.assign(n + 1, 0);
    std::partial_sum(counts.begin(), counts.end(), graph.first.begin() + 1);

    graph.colour.assign(n, -1);
    std::vector<int> taken; // per colour the last leaf that saw it beside itself
    for (std::size_t i = 0; i < n; ++i)
    {
        if (!level.leaves[i].is_refined())
            continue;
        for (int j = graph.first[i]; j < graph.first[i + 1]; ++j)
            if (const int c = graph.colour[std::size_t(graph.neighbour[std::size_t(j)])]; c >= 0)
                taken[std::size_t(c)] = int(i);
        std::size_t c = 0;
        while (c < taken.size() && taken[c] == int(i))
            ++c;
        if (c == taken.size())
            taken.push_back(-1);
        graph.colour[i] = int(c);
    }
    graph.is_empty = taken.empty();
    return graph;
}

std::vector<int> places_of_ids(const Level& level, int ids, int threads)
{
    std::vector<int> places(std::size_t(ids), -1);
    parallel_for(
        level.points.size(), threads, {}, [&](std::size_t i) { places[std::size_t(level.points[i].id)] = int(i); },
        8192);
    return places;
}

int leaf_of_place(const Level& level, int place)
{
    const auto after = std::upper_bound(level.leaves.begin(), level.leaves.end(), place,
                                        [](int p, const Leaf& leaf) { return p < leaf.begin; });
    return int(after - level.leaves.begin()) - 1;
}

} // namespace recon::pn
