#pragma once

#include "local_points.h"

#include <recon/geometry.h>
#include <recon/progress.h>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace recon::pn
{

/// A point while it is refined: one cache line.
struct WorkPoint
{
    WorkPoint() {} ///< Sets nothing: the thread that fills a new level is the first to touch its pages.

    Point position;
    Vector normal;
    float radius;
    float spacing; ///< Usual distance between points around here before the first step.
    int id;        ///< Place in the output.
    enum Flag : std::uint32_t
    {
        refined = 1,        ///< Its neighbourhood is completed in the next step.
        frozen = 2,         ///< Never refined.
        crease = 4,         ///< Shares its position with others of other normals,
        above = 8,          ///< with one, and its face lies above the plane of that,
        below = 16,         ///< or below.
        sector = 32,        ///< Or with two, and its face is a sector
        reflex = 64,        ///< (of more than half a turn)
        above_first = 128,  ///< above the plane of the first of these in the order of normals, else below,
        above_second = 256, ///< and (if reflex, or) above that of the second, else below.
        near_mouth = 512    ///< See Mouths.
    };
    std::uint32_t flags;
};

/// Up to leaf_capacity points next to each other in space and in memory: what one task refines.
struct Leaf
{
    int begin = 0, end = 0;
    Box box;
    double largest_radius = 0;
    int refined_count = 0;    ///< Points to refine.
    bool has_creases = false; ///< Holds points that share their position with others.

    int size() const { return end - begin; }
    bool is_refined() const { return refined_count > 0; }
};

constexpr int leaf_capacity = 64;

/// Points as rows of single-precision numbers, relative to the centre of their leaf's box. Whole vectors may be read
/// beyond the last.
struct RowsView
{
    const float *x, *y, *z, *nx, *ny, *nz, *radius;
    const float* largest_radius; ///< What it may be raised to; may be null.
    int count;
};

/// All points of one level as a sequence of leaves in the order of a kd-tree, so that neighbours in the sequence are
/// mostly neighbours in space.
struct Level
{
    std::vector<WorkPoint> points;
    std::vector<Leaf> leaves;
    std::array<std::unique_ptr<float[]>, 7> rows; ///< Of the points, as in RowsView.

    RowsView rows_of(const Leaf& leaf) const
    {
        const auto at = [&](std::size_t r) { return rows[r].get() + leaf.begin; };
        return {at(0), at(1), at(2), at(3), at(4), at(5), at(6), nullptr, leaf.size()};
    }
};

/// Points inserted while the points of a leaf are refined. What neighbours need to know of them is kept in single
/// precision, relative to the centre of the leaf's box; they are made in double at the end of the step.
class LeafChildren
{
public:
    /// x, y, z, nx, ny, nz, radius, largest radius.
    using Row = std::array<float, 8>;

    int count() const { return count_; }
    /// Uses this memory, room for `capacity` children, until there are more. \pre The children so far, if any, are
    /// there already; capacity is a multiple of lane_count.
    void use(float* rows, std::array<int, 3>* corners, int capacity)
    {
        rows_ = rows;
        corners_ = corners;
        capacity_ = capacity;
    }
    void reserve(int n);
    /// Centre of the PN triangle of three points of the level, given by their places.
    void append(const std::array<int, 3>& corners, const Row& row)
    {
        if (count_ == capacity_)
            reserve(count_ + count_ / 2 + 16);
        for (std::size_t r = 0; r < 8; ++r)
            rows_[r * std::size_t(capacity_) + std::size_t(count_)] = row[r];
        corners_[count_++] = corners;
    }
    /// A point that is made already, number `made` of Growth::made; `corners` are the points it comes from.
    void append_made(int made, const std::array<int, 3>& corners, const Row& row)
    {
        made_.push_back({count(), made});
        append(corners, row);
    }

    RowsView rows() const
    {
        const auto at = [&](std::size_t r) { return rows_ + r * std::size_t(capacity_); };
        return {at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7), count()};
    }
    float& radius(int i) { return rows_[6 * std::size_t(capacity_) + std::size_t(i)]; }
    const std::array<int, 3>* corners() const { return corners_; }
    const std::vector<std::array<int, 2>>& made() const { return made_; } ///< (Own index, number).

private:
    int count_ = 0, capacity_ = 0;
    float* rows_ = nullptr;
    std::array<int, 3>* corners_ = nullptr;
    std::unique_ptr<float[]> own_rows_; ///< Where the caller's memory was too small.
    std::unique_ptr<std::array<int, 3>[]> own_corners_;
    std::vector<std::array<int, 2>> made_;
};

/// Memory for the children of all leaves of a level, used again for those of the next. In thousands of small pieces it
/// took one thread 2 % of a run to give back; in a new piece each step more pages were touched for the first time.
class ChildrenMemory
{
public:
    /// One empty list per leaf, with room for twice its points if any is refined. Lists given before are void.
    std::vector<LeafChildren> lists_for(const Level& level);

private:
    static constexpr int block_size = 16384; // children
    struct alignas(4 * lane_count) Line
    {
        float values[lane_count];
    };
    struct Block
    {
        std::unique_ptr<Line[]> rows;
        std::unique_ptr<std::array<int, 3>[]> corners;
    };
    std::vector<Block> blocks_;
};

/// Sorts points into leaves.
Level make_level(std::vector<WorkPoint> points);

/// What a step adds to a level.
struct Growth
{
    const std::vector<LeafChildren>& children;
    const std::vector<WorkPoint>& made;    ///< Points made already.
    const std::vector<int>& first;         ///< Per leaf: children of those before it; and their number.
    const std::vector<float>& next_radius; ///< Per point of the level.
    int first_id;                          ///< Of the first child.
    double target_radius;                  ///< Points with a radius at most this are no longer refined.
    /// Called for each point made from the points of the level at these places, to move it to a better one; may be
    /// empty.
    std::function<void(const std::array<int, 3>& corners, WorkPoint& made)> correct;
};

/// Where the children of a step go, in the order of their ids: positions and radii in the frame's input units.
struct Appended
{
    Point* points;
    Vector* normals;
    std::array<int, 3>* parents; ///< Their ids.
    double* radii;
};

/// The next level: each leaf's points and then its children, split where they are too many. The children are appended
/// as well.
Level grow_level(const Level& level, const Growth& growth, const UnitFrame& frame, const Appended& appended,
                 int threads, const Progress& progress);

/// The same where no step follows: appends the children and makes no level.
void append_children(const Level& level, const Growth& growth, const UnitFrame& frame, const Appended& appended,
                     int threads, const Progress& progress);

/// Leaves whose refinement may touch the same points: those whose boxes, grown by their largest radii, meet.
struct LeafGraph
{
    std::vector<int> first, neighbour; ///< Compressed rows, a leaf's own index left out, ascending.
    std::vector<int> colour;           ///< Per leaf; those that meet differ. -1: has no point to refine.
    bool is_empty = true;              ///< No leaf has a colour.
};
LeafGraph connect_leaves(const Level& level, int threads, const Progress& progress);

/// Squared distance between two boxes, 0 if they meet.
double squared_distance(const Box& a, const Box& b);

/// Position in level.points of each id below `ids`, -1 for none.
std::vector<int> places_of_ids(const Level& level, int ids, int threads);

/// Leaf that holds the point at this place.
int leaf_of_place(const Level& level, int place);

} // namespace recon::pn
