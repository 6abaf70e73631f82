#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>

#include <array>
#include <cstdint>
#include <vector>

namespace recon::pn
{

/// A point while it is refined: one cache line.
struct WorkPoint
{
    Point position;
    Vector normal;
    double radius = 0;
    int id = 0; ///< Place in the output.
    enum Flag : std::uint32_t
    {
        refined = 1, ///< Its neighbourhood is completed in the next step.
        frozen = 2,  ///< Never refined.
        crease = 4   ///< Shares its position with others of other normals.
    };
    std::uint32_t flags = refined;
};

/// A new point with the points it was made from.
struct Child
{
    WorkPoint point;
    std::array<int, 3> parents; ///< Ids.
    double largest_radius = 0;  ///< Its radius may not be raised above this.
};

/// Up to leaf_capacity points next to each other in space and in memory: what one task refines.
struct Leaf
{
    int begin = 0, end = 0;
    Box box;
    double largest_radius = 0;
    bool is_refined = false; ///< Holds points to refine.

    int size() const { return end - begin; }
};

constexpr int leaf_capacity = 48;

/// All points of one level as a sequence of leaves in the order of a kd-tree, so that neighbours in the sequence are
/// mostly neighbours in space.
struct Level
{
    std::vector<WorkPoint> points;
    std::vector<Leaf> leaves;
};

/// Sorts points into leaves.
Level make_level(std::vector<WorkPoint> points);

/// The next level: each leaf's points and then its children, split where they are too many. Radii are taken from
/// `next_radius` (one per point of `level`); points with a radius at most `target_radius` are no longer refined. The
/// children must have their ids.
Level grow_level(const Level& level, const std::vector<std::vector<Child>>& children,
                 const std::vector<double>& next_radius, double target_radius, int threads, const Progress& progress);

/// Leaves whose refinement may touch the same points: those whose boxes, grown by their largest radii, meet. Leaves of
/// one colour do not, so they can be refined side by side.
struct LeafGraph
{
    std::vector<int> first, neighbour;     ///< Compressed rows, a leaf's own index left out, ascending.
    std::vector<std::vector<int>> colours; ///< Leaves with points to refine, ascending in each.
};
LeafGraph connect_leaves(const Level& level, int threads, const Progress& progress);

/// Position in level.points of each id below `ids`, -1 for none.
std::vector<int> places_of_ids(const Level& level, int ids);

/// Leaf that holds the point at this place.
int leaf_of_place(const Level& level, int place);

} // namespace recon::pn
