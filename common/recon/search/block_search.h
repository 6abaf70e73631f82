#pragma once

#include <recon/geometry.h>

#include <cstddef>
#include <utility>
#include <vector>

namespace recon
{

/// Neighbour queries on points in spatial order (order_spatially(), or a subset of it): boxes around 8 consecutive
/// points, around 8 such boxes and so on. Built in a twentieth of the time of NeighbourSearch; what lies within a
/// radius is found in half the time, since 8 boxes or points are tested at once. In another order it is right but slow.
/// Queries may run on many threads at once.
class BlockSearch
{
public:
    BlockSearch() = default; ///< Finds nothing.
    /// Copies the points. \param threads to build with [count], >= 1.
    explicit BlockSearch(const Points& points, int threads = 1);
    BlockSearch(BlockSearch&&) noexcept = default;
    BlockSearch& operator=(BlockSearch&&) noexcept = default;

    /// Writes the min(k, size) nearest points to `indices` and their squared distances to `squared`, nearest first, of
    /// equal ones the lowest index. Both arrays hold at least k entries. \param reach a guess of the distance of the
    /// k-th, 0 for none; becomes a good one for a query nearby. Only the time depends on it, a little. \returns how
    /// many there are. \pre query and its squared distances are finite.
    int nearest(const Point& query, int k, int* indices, double* squared, double& reach) const;
    int nearest(const Point& query, int k, int* indices, double* squared) const;

    /// Index of the nearest point, -1 if there are none. For many queries side by side: nearest_samples.h.
    int nearest(const Point& query) const;

    /// Indices of all points within `radius` of `query`, ascending; replaces the content of `indices`.
    void within(const Point& query, double radius, std::vector<int>& indices) const;

    /// Whether at least `wanted` points lie within `radius` of `query`, however many they are.
    bool has_within(const Point& query, double radius, int wanted) const;

    static constexpr int fan = 8;

    struct alignas(64) Box
    {
        double low[3][fan], high[3][fan]; ///< Of the 8 children.
    };
    struct alignas(64) Leaf
    {
        double p[3][fan];
    };

private:
    /// Of the i-th leaf, or box of the highest level so far.
    std::pair<double, double> bounds(std::size_t i, int axis) const;
    double diagonal() const; ///< \pre there are points

    std::size_t size_ = 0;
    double spacing_ = 0; ///< Some guess.
    std::vector<Leaf> leaves_;
    std::vector<std::vector<Box>> levels_; ///< levels_[0] over the leaves.
    std::vector<const Box*> level_starts_; ///< Of levels_.
};

} // namespace recon
