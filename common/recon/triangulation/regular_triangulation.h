#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>
#include <recon/triangulation/power_predicates.h>
#include <recon/triangulation/triangulation.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

namespace recon
{

/// Regular triangulation (of equal weights: Delaunay) by incremental insertion: each site takes out the cells whose
/// orthogonal sphere it lies in and joins their hull (Bowyer 1981, Watson 1981). Predicates are exact. Where five sites
/// touch one sphere, the site of the lower index counts as heavier by an infinitesimal (Devillers and Teillaud 2011),
/// so the triangulation is unique: it depends neither on the order of insertion nor on the threads.
///
/// Threads work on their own stretches of a space-filling curve through the sites. Each cell has an owner while a
/// thread reads or changes it (as in Levy's Geogram); nobody waits for a cell: the site is put off, in the end until
/// the threads have joined. CGAL's parallel mode spins on its locks instead: on a busy machine it took nine times the
/// processor time.
class RegularTriangulation
{
public:
    /// Of the points whose indices are `members`; of equal points only the heaviest (the first of those) is inserted.
    /// \param weights per point; empty: all 0. \pre coordinates are finite, of the order of 1 (UnitFrame).
    /// \throws Cancelled.
    RegularTriangulation(const Points& points, const std::vector<double>& weights, const std::vector<int>& members,
                         int threads, const Progress& progress);

    /// As flat arrays, with the power centres; no cells if all points are coplanar. Vertices of a cell ascend but for
    /// the last two, which keep the orientation. Finite cells go by their vertices: where the points are in a spatial
    /// order, so are the cells then, and walks stay in the cache. \param points, weights as they were given. Frees what
    /// it has copied on the way: call it once.
    Triangulation flatten(const Points& points, const std::vector<double>& weights, int threads) &&;

private:
    using Cell = Triangulation::Cell;

    /// Edge of a facet of the hull, in the direction in which the facet has it.
    struct HullEdge
    {
        unsigned fill = 0; ///< Of which hole; others count as empty.
        int from, to;      ///< Vertices.
        int facet;         ///< Position in `hull`.
    };

    /// Cells by their lowest vertex, finite ones first, infinite ones by their lowest finite vertex after them; within
    /// a bucket in any order.
    struct Buckets
    {
        std::vector<int> first; ///< Per bucket, twice as many as points; one more ends them.
        std::vector<int> cells;
    };

    /// What one thread works with.
    struct Worker
    {
        std::uint8_t owner = nobody;          ///< `nobody` for one that is alone.
        int hint = none;                      ///< A cell, possibly dead.
        std::vector<int> owned;               ///< Cells.
        std::vector<int> free;                ///< Dead cells.
        int unused_begin = 0, unused_end = 0; ///< Cells never used so far that are the worker's to use.
        std::uint32_t random = 1;
        std::vector<int> conflicts, others; ///< Cells that a site takes out, and those tested that stay.
        std::vector<std::array<int, 2>>
            hull;               ///< Facets between the two: position in `conflicts`, position of the vertex opposite.
        std::vector<int> fresh; ///< Cells to be, one per facet of the hull.
        std::vector<HullEdge> edges; ///< Hash table.
        unsigned fills = 0;          ///< Holes filled so far.
        std::vector<int> put_off;    ///< Sites.
    };
    enum class Outcome
    {
        inserted,
        hidden,
        put_off,
        out_of_cells
    };

    static constexpr int none = -1;
    static constexpr int dead = -2; ///< First vertex of cells that are no more.
    static constexpr std::uint8_t nobody = 0;

    void order_sites(const Points& points, const std::vector<double>& weights, const std::vector<int>& members);
    bool make_first_cells();
    void insert_all(int threads, const Progress& progress);
    void insert_side_by_side(const std::vector<int>& sites, int threads, const Progress& progress);
    void insert_one_by_one(const std::vector<int>& sites, const Progress& progress);
    int find_any_cell() const;
    void grow(std::size_t capacity);

    Outcome insert(int site, Worker& worker);
    bool own(int cell, Worker& worker);
    void disown(Worker& worker);
    int locate(int site, Worker& worker);
    bool own_for_test(int cell, Worker& worker);
    bool find_conflicts(int site, int first, Worker& worker);
    bool find_fresh_cells(Worker& worker);
    bool take_slab(Worker& worker);
    void fill_hole(int site, Worker& worker);
    void join_along_edges(Worker& worker);

    bool is_infinite(const Cell& c) const
    {
        return (c.vertices[0] | c.vertices[1] | c.vertices[2] | c.vertices[3]) < 0;
    }
    Cell name_vertices(Cell cell) const;
    /// \param n points.
    Buckets sort_into_buckets(std::size_t n, int threads) const;
    /// Fills `flat.cells`; their neighbours keep the numbers of before. \returns position in `flat` per number.
    std::vector<int> name_cells(const Buckets& buckets, Triangulation& flat, int threads) const;
    int find_orientation_with(const Cell& c, int position, int site) const;
    bool is_in_conflict(const Cell& c, int site) const;
    bool is_in_perturbed_conflict(const Cell& c, int site) const;

    std::vector<Site> sites_;  ///< Along the curve.
    std::vector<int> indices_; ///< Of the sites, in the points.
    std::unique_ptr<Cell[]> cells_;
    std::vector<int> marks_; ///< Per cell: 1 + its position among the conflicts, -1 if tested and not one, else 0.
    std::unique_ptr<std::atomic<std::uint8_t>[]> owners_; ///< Per cell.
    int used_ = 0;                                        ///< Cells handed out so far, dead ones among them.
    std::atomic<int> next_slab_{0}; ///< First cell that belongs to no worker yet, while there are several.
    Worker serial_;                 ///< For when there is one thread.
};

} // namespace recon
