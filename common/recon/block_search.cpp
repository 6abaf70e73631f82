#include <recon/block_search.h>

#include <recon/vector_clones.h>

#include <boost/container/small_vector.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace recon
{
namespace
{

constexpr int fan = BlockSearch::fan;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int deepest = 256; // a path of 11 levels leaves at most 7 siblings on each

/// A place in the tree: of level -1 a leaf.
struct Node
{
    double squared; ///< To its box.
    int level, index;
};

RECON_INLINE void measure_boxes(const BlockSearch::Box& box, const double* q, double* squared)
{
    for (int k = 0; k < fan; ++k)
    {
        double sum = 0;
        for (int axis = 0; axis < 3; ++axis)
        {
            const double below = box.low[axis][k] - q[axis], above = q[axis] - box.high[axis][k];
            double d = below > above ? below : above;
            d = d > 0 ? d : 0;
            sum += d * d;
        }
        squared[k] = sum;
    }
}

/// To the farthest corners.
RECON_INLINE void measure_corners(const BlockSearch::Box& box, const double* q, double* squared)
{
    for (int k = 0; k < fan; ++k)
    {
        double sum = 0;
        for (int axis = 0; axis < 3; ++axis)
        {
            const double low = q[axis] - box.low[axis][k], high = box.high[axis][k] - q[axis];
            const double d = low > high ? low : high;
            sum += d * d;
        }
        squared[k] = sum;
    }
}

RECON_INLINE void measure_points(const BlockSearch::Leaf& leaf, const double* q, double* squared)
{
    for (int k = 0; k < fan; ++k)
    {
        const double x = leaf.p[0][k] - q[0], y = leaf.p[1][k] - q[1], z = leaf.p[2][k] - q[2];
        squared[k] = x * x + y * y + z * z;
    }
}

/// What the queries read.
struct Tree
{
    Tree(const std::vector<BlockSearch::Leaf>& all_leaves, const std::vector<const BlockSearch::Box*>& starts,
         std::size_t points)
        : leaves(all_leaves.data()), levels(starts.data()), level_count(int(starts.size())), size(std::int64_t(points))
    {
    }

    const BlockSearch::Leaf* leaves;
    const BlockSearch::Box* const* levels;
    int level_count;
    std::int64_t size; ///< Number of points.

    static int first_point(const Node& node) { return int(std::int64_t(node.index) * fan << (3 * (node.level + 1))); }
    /// The number of points in a full child of a node.
    static std::int64_t child_size(const Node& node) { return std::int64_t(fan) << (3 * node.level); }
    bool is_full(const Node& node, int child) const
    {
        return (std::int64_t(node.index) * fan + child + 1) * child_size(node) <= size;
    }
};

/// Calls visit(first index, squared distances of 8 points) for the leaves that come as near as `limit`, in the
/// order of the points. The visit may lower the limit.
template <class Visit>
RECON_INLINE void visit_leaves(const Tree& tree, const double* q, double& limit, Visit&& visit)
{
    Node stack[deepest];
    int depth = 0;
    stack[depth++] = {0, tree.level_count - 1, 0};
    while (depth > 0)
    {
        const Node node = stack[--depth];
        if (node.squared > limit)
            continue;
        double d[fan];
        if (node.level < 0)
        {
            measure_points(tree.leaves[node.index], q, d);
            visit(node.index * fan, d);
            continue;
        }
        measure_boxes(tree.levels[node.level][node.index], q, d);
        for (int j = fan - 1; j >= 0; --j)
        {
            stack[depth] = {d[j], node.level - 1, node.index * fan + j};
            depth += d[j] <= limit;
        }
    }
}

/// The square of a radius; finite, so that what fills up the last leaf stays out.
double limit_of(double radius)
{
    return std::min(radius * radius, std::numeric_limits<double>::max());
}

struct Candidate
{
    double squared;
    int index;
    bool operator<(const Candidate& o) const
    {
        return squared < o.squared || (squared == o.squared && index < o.index);
    }
};

using Candidates = boost::container::small_vector<Candidate, 96>;

/// Keeps the k nearest, the farthest of them last, otherwise unsorted.
void keep_nearest(Candidates& candidates, int k)
{
    std::nth_element(candidates.begin(), candidates.begin() + (k - 1), candidates.end());
    candidates.resize(std::size_t(k));
}

/// All within the limit, unless there are more than `most`.
RECON_VECTOR_CLONES
void collect_candidates(const Tree& tree, const double* q, double limit, std::size_t most, Candidates* candidates)
{
    visit_leaves(tree, q, limit,
                 [&](int first, const double* d) RECON_INLINE_LAMBDA
                 {
                     Candidate found[fan];
                     int count = 0;
                     for (int j = 0; j < fan; ++j)
                     {
                         found[count] = {d[j], first + j};
                         count += d[j] <= limit;
                     }
                     candidates->insert(candidates->end(), found, found + count);
                     if (candidates->size() > most)
                         limit = -1;
                 });
}

/// The k nearest and some more, without a guess: from near to far, as far as the k-th found so far, or the far corner
/// of a box of that many.
RECON_VECTOR_CLONES
void collect_nearest(const Tree& tree, const double* q, int k, Candidates* candidates)
{
    const std::size_t room = std::size_t(k) + 2 * fan;
    Candidate last{std::numeric_limits<double>::max(), std::numeric_limits<int>::max()};
    Node stack[deepest];
    int depth = 0;
    stack[depth++] = {0, tree.level_count - 1, 0};
    while (depth > 0)
    {
        const Node node = stack[--depth];
        if (last < Candidate{node.squared, Tree::first_point(node)})
            continue;
        double d[fan];
        if (node.level < 0)
        {
            measure_points(tree.leaves[node.index], q, d);
            for (int j = 0; j < fan; ++j)
                if (d[j] <= last.squared)
                    candidates->push_back({d[j], node.index * fan + j});
            if (candidates->size() > room)
            {
                keep_nearest(*candidates, k);
                last = candidates->back();
            }
            continue;
        }
        measure_boxes(tree.levels[node.level][node.index], q, d);
        if (Tree::child_size(node) >= k)
        {
            double far[fan];
            measure_corners(tree.levels[node.level][node.index], q, far);
            for (int j = 0; j < fan; ++j)
                if (far[j] < last.squared && tree.is_full(node, j))
                    last = {far[j], std::numeric_limits<int>::max()};
        }
        const int base = depth;
        for (int j = fan - 1; j >= 0; --j)
            if (d[j] <= last.squared)
            {
                int at = depth++;
                for (; at > base && stack[at - 1].squared < d[j]; --at)
                    stack[at] = stack[at - 1];
                stack[at] = {d[j], node.level - 1, node.index * fan + j};
            }
    }
}

RECON_VECTOR_CLONES
void collect_within(const Tree& tree, const double* q, double limit, std::vector<int>* indices)
{
    constexpr int room = 64 * fan;
    int found[room], count = 0;
    visit_leaves(tree, q, limit,
                 [&](int first, const double* d) RECON_INLINE_LAMBDA
                 {
                     if (count > room - fan)
                     {
                         indices->insert(indices->end(), found, found + count);
                         count = 0;
                     }
                     for (int j = 0; j < fan; ++j)
                     {
                         found[count] = first + j;
                         count += d[j] <= limit;
                     }
                 });
    indices->insert(indices->end(), found, found + count);
}

RECON_VECTOR_CLONES
bool find_within(const Tree& tree, const double* q, double limit, int wanted)
{
    visit_leaves(tree, q, limit,
                 [&](int, const double* d) RECON_INLINE_LAMBDA
                 {
                     for (int j = 0; j < fan; ++j)
                         wanted -= d[j] <= limit;
                     if (wanted <= 0)
                         limit = -1;
                 });
    return wanted <= 0;
}

} // namespace

BlockSearch::BlockSearch(const Points& points) : size_(points.size())
{
    if (size_ > 0)
        spacing_ = bounding_box(points).diagonal() / std::sqrt(double(size_));
    // Entries beyond the last point are infinitely far: infinity - infinity never occurs, queries are finite.
    leaves_.resize((size_ + fan - 1) / fan);
    for (std::size_t i = 0; i < leaves_.size() * fan; ++i)
        for (int axis = 0; axis < 3; ++axis)
            leaves_[i / fan].p[axis][i % fan] = i < size_ ? points[i][axis] : infinity;
    std::size_t below = leaves_.size();
    while (below > 0)
    {
        std::vector<Box> level((below + fan - 1) / fan);
        for (std::size_t i = 0; i < level.size() * fan; ++i)
            for (int axis = 0; axis < 3; ++axis)
            {
                double low = infinity, high = -infinity;
                if (i < below)
                    for (int k = 0; k < fan; ++k)
                    {
                        if (levels_.empty())
                        {
                            if (i * fan + std::size_t(k) >= size_)
                                continue;
                            low = std::min(low, leaves_[i].p[axis][k]);
                            high = std::max(high, leaves_[i].p[axis][k]);
                        }
                        else
                        {
                            low = std::min(low, levels_.back()[i].low[axis][k]);
                            high = std::max(high, levels_.back()[i].high[axis][k]);
                        }
                    }
                level[i / fan].low[axis][i % fan] = low;
                level[i / fan].high[axis][i % fan] = high;
            }
        below = level.size() > 1 ? level.size() : 0;
        levels_.push_back(std::move(level));
    }
    for (const auto& level : levels_)
        level_starts_.push_back(level.data());
}

int BlockSearch::nearest(const Point& query, int k, int* indices, double* squared, double& reach) const
{
    k = int(std::min<std::size_t>(size_, std::size_t(std::max(k, 0))));
    if (k == 0)
        return 0;
    const Tree tree(leaves_, level_starts_, size_);
    Candidates candidates;
    // A guess may be far off: the last query lay among other spacings.
    const std::size_t most = std::size_t(8 * k + 8 * fan);
    const double radius = reach > 0 ? reach : spacing_ * std::sqrt(double(k));
    collect_candidates(tree, query.data(), limit_of(radius), most, &candidates);
    if (candidates.size() < std::size_t(k) || candidates.size() > most)
    {
        candidates.clear();
        collect_nearest(tree, query.data(), k, &candidates);
    }
    keep_nearest(candidates, k);
    std::sort(candidates.begin(), candidates.end());
    for (int i = 0; i < k; ++i)
    {
        indices[i] = candidates[i].index;
        squared[i] = candidates[i].squared;
    }
    reach = 1.15 * std::sqrt(squared[k - 1]);
    return k;
}

int BlockSearch::nearest(const Point& query, int k, int* indices, double* squared) const
{
    double reach = 0;
    return nearest(query, k, indices, squared, reach);
}

int BlockSearch::nearest(const Point& query) const
{
    int index = -1;
    double squared = 0;
    return nearest(query, 1, &index, &squared) > 0 ? index : -1;
}

void BlockSearch::within(const Point& query, double radius, std::vector<int>& indices) const
{
    indices.clear();
    if (size_ == 0)
        return;
    const Tree tree(leaves_, level_starts_, size_);
    collect_within(tree, query.data(), limit_of(radius), &indices);
}

bool BlockSearch::has_within(const Point& query, double radius, int wanted) const
{
    const Tree tree(leaves_, level_starts_, size_);
    return size_ > 0 && find_within(tree, query.data(), limit_of(radius), wanted);
}

} // namespace recon
