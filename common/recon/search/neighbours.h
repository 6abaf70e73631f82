#pragma once

#include <recon/geometry.h>

#include <memory>

namespace recon
{

class BlockSearch;

/// Nearest-neighbour queries on a fixed set of points (nanoflann). Queries may run on many threads at once.
class NeighbourSearch
{
public:
    /// Keeps a reference to `points`; they must outlive this object. May be empty.
    explicit NeighbourSearch(const Points& points);
    explicit NeighbourSearch(Points&& points) = delete;
    ~NeighbourSearch();
    NeighbourSearch(NeighbourSearch&&) noexcept;
    NeighbourSearch& operator=(NeighbourSearch&&) noexcept;

    /// Writes the min(k, size) nearest points to `indices` and their squared distances to `squared`, nearest first.
    /// Both arrays hold at least k entries. A query that is one of the points finds itself. \returns how many there
    /// are.
    int nearest(const Point& query, int k, int* indices, double* squared) const;

    /// Index of the nearest point, -1 if there are none.
    int nearest(const Point& query) const;

    /// Indices of all points within `radius` of `query`, unordered; replaces the content of `indices`.
    void within(const Point& query, double radius, std::vector<int>& indices) const;

private:
    struct Tree;
    std::unique_ptr<Tree> tree_;
};

/// Mean distance of `point`, one of those searched, to the six nearest others; 0 if it is alone.
double measure_spacing_at(const Point& point, const NeighbourSearch& search);
double measure_spacing_at(const Point& point, const BlockSearch& search);

} // namespace recon
