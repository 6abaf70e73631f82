#include <recon/search/block_search.h>

#include <recon/parallel.h>
#include <recon/simd.h>
#include <recon/vector_clones.h>

#include <boost/container/small_vector.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <tuple>
#include <utility>

namespace recon
{
namespace
{

using simd::HalfLanes;

constexpr int fan = BlockSearch::fan;
static_assert(fan == simd::lane_count);
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int most_levels = 11; // of as many points as an index counts
constexpr int deepest = 256;    // a path leaves at most 7 siblings on each level

/// A place in the tree: of level -1 a leaf.
struct Node
{
    double squared; ///< To its box.
    int level, index;
};

/// Squared distances of 8 boxes or points.
struct Squares
{
    HalfLanes half[2];
};

/// From 8 boxes.
RECON_INLINE Squares measure_boxes(const BlockSearch::Box& box, const double* q)
{
    Squares squares = {};
    for (int h = 0; h < 2; ++h)
        for (int axis = 0; axis < 3; ++axis)
        {
            const HalfLanes below = simd::load_half(box.low[axis] + 4 * h) - q[axis],
                            above = q[axis] - simd::load_half(box.high[axis] + 4 * h);
            const HalfLanes d = simd::larger(simd::larger(below, above), HalfLanes{});
            squares.half[h] += d * d;
        }
    return squares;
}

/// To the farthest corners.
RECON_INLINE Squares measure_corners(const BlockSearch::Box& box, const double* q)
{
    Squares squares = {};
    for (int h = 0; h < 2; ++h)
        for (int axis = 0; axis < 3; ++axis)
        {
            const HalfLanes d = simd::larger(q[axis] - simd::load_half(box.low[axis] + 4 * h),
                                             simd::load_half(box.high[axis] + 4 * h) - q[axis]);
            squares.half[h] += d * d;
        }
    return squares;
}

RECON_INLINE Squares measure_points(const BlockSearch::Leaf& leaf, const double* q)
{
    Squares squares;
    for (int h = 0; h < 2; ++h)
    {
        const HalfLanes x = simd::load_half(leaf.p[0] + 4 * h) - q[0], y = simd::load_half(leaf.p[1] + 4 * h) - q[1],
                        z = simd::load_half(leaf.p[2] + 4 * h) - q[2];
        squares.half[h] = x * x + y * y + z * z;
    }
    return squares;
}

RECON_INLINE void store(double* values, const Squares& squares)
{
    std::memcpy(values, &squares, sizeof squares);
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

/// Of each mask: the bits that are set, in ascending order.
constexpr std::array<std::array<std::uint8_t, fan>, 1 << fan> list_set_bits()
{
    std::array<std::array<std::uint8_t, fan>, 1 << fan> bits{};
    for (unsigned mask = 0; mask < 1u << fan; ++mask)
    {
        int count = 0;
        for (unsigned k = 0; k < fan; ++k)
            if (mask >> k & 1)
                bits[mask][std::size_t(count++)] = std::uint8_t(k);
    }
    return bits;
}
constexpr auto set_bits = list_set_bits();

/// Bit j: whether the j-th is at most `limit`.
RECON_INLINE unsigned mask_of(const Squares& squares, double limit)
{
    using Bits = std::int64_t __attribute__((vector_size(32)));
    constexpr Bits first = {1, 2, 4, 8}, second = {16, 32, 64, 128};
    const Bits bits = ((squares.half[0] <= limit) & first) | ((squares.half[1] <= limit) & second);
    return unsigned((bits[0] | bits[2]) | (bits[1] | bits[3]));
}

/// Calls visit(first index, squared distances of 8 points) for the leaves that come as near as `limit`, in the
/// order of the points, until it returns false.
template <class Visit>
RECON_INLINE void visit_leaves(const Tree& tree, const double* q, double limit, Visit&& visit)
{
    int index[most_levels];     // of the box on each level,
    unsigned left[most_levels]; // and its children still to be visited
    const auto enter = [&](int level, int box) RECON_INLINE_LAMBDA
    {
        index[level] = box;
        left[level] = mask_of(measure_boxes(tree.levels[level][box], q), limit);
    };
    int level = tree.level_count - 1;
    enter(level, 0);
    while (level < tree.level_count)
    {
        const unsigned mask = left[level];
        if (mask == 0)
        {
            ++level;
            continue;
        }
        left[level] = mask & (mask - 1);
        const int child = index[level] * fan + __builtin_ctz(mask);
        if (level > 0)
        {
            enter(--level, child);
            continue;
        }
        if (!visit(child * fan, measure_points(tree.leaves[child], q)))
            return;
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
                 [&](int first, const Squares& d) RECON_INLINE_LAMBDA
                 {
                     double squared[fan];
                     store(squared, d);
                     for (unsigned mask = mask_of(d, limit); mask != 0; mask &= mask - 1)
                     {
                         const int j = __builtin_ctz(mask);
                         candidates->push_back({squared[j], first + j});
                     }
                     return candidates->size() <= most;
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
            store(d, measure_points(tree.leaves[node.index], q));
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
        store(d, measure_boxes(tree.levels[node.level][node.index], q));
        if (Tree::child_size(node) >= k)
        {
            double far[fan];
            store(far, measure_corners(tree.levels[node.level][node.index], q));
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
                 [&](int first, const Squares& d) RECON_INLINE_LAMBDA
                 {
                     if (count > room - fan)
                     {
                         indices->insert(indices->end(), found, found + count);
                         count = 0;
                     }
                     const unsigned mask = mask_of(d, limit);
                     const std::uint8_t* places = set_bits[mask].data();
                     for (int j = 0; j < fan; ++j)
                         found[count + j] = first + places[j];
                     count += __builtin_popcount(mask);
                     return true;
                 });
    indices->insert(indices->end(), found, found + count);
}

RECON_VECTOR_CLONES
bool find_within(const Tree& tree, const double* q, double limit, int wanted)
{
    visit_leaves(tree, q, limit,
                 [&](int, const Squares& d) RECON_INLINE_LAMBDA
                 {
                     wanted -= __builtin_popcount(mask_of(d, limit));
                     return wanted > 0;
                 });
    return wanted <= 0;
}

} // namespace

BlockSearch::BlockSearch(const Points& points, int threads) : size_(points.size())
{
    constexpr std::size_t grain = 1024;
    // Entries beyond the last point are infinitely far: infinity - infinity never occurs, queries are finite.
    leaves_.resize((size_ + fan - 1) / fan);
    parallel_for(
        leaves_.size(), threads, {},
        [&](std::size_t leaf)
        {
            for (std::size_t k = 0; k < fan; ++k)
                for (int axis = 0; axis < 3; ++axis)
                    leaves_[leaf].p[axis][k] = leaf * fan + k < size_ ? points[leaf * fan + k][axis] : infinity;
        },
        grain);
    std::size_t below = leaves_.size();
    while (below > 0)
    {
        std::vector<Box> level((below + fan - 1) / fan);
        parallel_for(
            level.size(), threads, {},
            [&](std::size_t box)
            {
                for (std::size_t k = 0; k < fan; ++k)
                    for (int axis = 0; axis < 3; ++axis)
                        std::tie(level[box].low[axis][k], level[box].high[axis][k]) = bounds(box * fan + k, axis);
            },
            grain);
        below = level.size() > 1 ? level.size() : 0;
        levels_.push_back(std::move(level));
    }
    for (const auto& level : levels_)
        level_starts_.push_back(level.data());
    if (size_ > 0)
        spacing_ = diagonal() / std::sqrt(double(size_));
}

std::pair<double, double> BlockSearch::bounds(std::size_t i, int axis) const
{
    double low = infinity, high = -infinity;
    if (levels_.empty())
        for (std::size_t k = 0; k < fan && i * fan + k < size_; ++k)
        {
            low = std::min(low, leaves_[i].p[axis][k]);
            high = std::max(high, leaves_[i].p[axis][k]);
        }
    else if (i < levels_.back().size())
        for (std::size_t k = 0; k < fan; ++k)
        {
            low = std::min(low, levels_.back()[i].low[axis][k]);
            high = std::max(high, levels_.back()[i].high[axis][k]);
        }
    return {low, high};
}

double BlockSearch::diagonal() const
{
    recon::Box all;
    const Box& root = levels_.back().front();
    for (int axis = 0; axis < 3; ++axis)
    {
        all.minimum[axis] = *std::min_element(root.low[axis], root.low[axis] + fan);
        all.maximum[axis] = *std::max_element(root.high[axis], root.high[axis] + fan);
    }
    return all.diagonal();
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
