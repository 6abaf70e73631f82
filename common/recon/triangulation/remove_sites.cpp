#include <recon/triangulation/remove_sites.h>

#include <recon/triangulation/regular_triangulation.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>
#include <utility>

namespace recon
{
namespace
{

constexpr int none = -1;

/// A facet seen from the cell that it belongs to: cells on one side of it have the same parity.
struct SidedFacet
{
    std::array<int, 3> vertices; ///< Ascending.
    bool odd;

    bool operator<(const SidedFacet& other) const
    {
        return vertices != other.vertices ? vertices < other.vertices : odd < other.odd;
    }
    bool operator==(const SidedFacet& other) const { return vertices == other.vertices && odd == other.odd; }
};

SidedFacet facet_opposite(const std::array<int, 4>& cell, int position)
{
    SidedFacet facet{{cell[(position + 1) & 3], cell[(position + 2) & 3], cell[(position + 3) & 3]},
                     (position & 1) != 0};
    for (const auto& [i, j] : {std::pair(0, 1), std::pair(1, 2), std::pair(0, 1)})
        if (facet.vertices[i] > facet.vertices[j])
        {
            std::swap(facet.vertices[i], facet.vertices[j]);
            facet.odd = !facet.odd;
        }
    return facet;
}

class Remover
{
public:
    Remover(Triangulation& triangulation, const Points& points, const std::vector<double>& weights,
            const std::vector<int>& removed)
        : t_(triangulation), points_(points), weights_(weights), cell_of_(points.size(), none),
          mark_(t_.cells.size(), none)
    {
        std::vector<char> leaves(points.size(), 0);
        for (const int v : removed)
            leaves[v] = 1;
        for (int c = 0; c < int(t_.cells.size()); ++c)
            for (const int v : t_.cells[c].vertices)
                if (v != Triangulation::infinite && leaves[v])
                    cell_of_[v] = c;
    }

    enum class Outcome
    {
        removed,
        out_of_cells, ///< The hole needs more than are free: others have to go first.
        failed
    };

    Outcome remove(int v)
    {
        const int start = cell_of_[v];
        if (start == none)
            return Outcome::removed;
        star_.assign(1, start);
        mark_[start] = v;
        hull_.clear();
        link_.clear();
        for (std::size_t k = 0; k < star_.size(); ++k)
        {
            if (!t_.is_finite(star_[k]))
                return Outcome::failed;
            const Triangulation::Cell& cell = t_.cells[star_[k]];
            for (int i = 0; i < 4; ++i)
            {
                const int beside = cell.neighbours[i];
                if (cell.vertices[i] == v)
                    hull_.push_back({facet_opposite(cell.vertices, i), beside});
                else
                {
                    link_.push_back(cell.vertices[i]);
                    if (mark_[beside] != v)
                    {
                        mark_[beside] = v;
                        star_.push_back(beside);
                    }
                }
            }
        }
        std::sort(link_.begin(), link_.end());
        link_.erase(std::unique(link_.begin(), link_.end()), link_.end());
        std::sort(hull_.begin(), hull_.end(), [](const Facet& a, const Facet& b) { return a.facet < b.facet; });
        return fill(v);
    }

    /// Fills the gaps that cells have left from the end of the finite ones, and their end from that of all.
    void close_gaps()
    {
        std::sort(gaps_.begin(), gaps_.end());
        const auto move = [&](int from, int to)
        {
            t_.cells[to] = t_.cells[from];
            if (to < t_.finite_cells && from < t_.finite_cells)
                t_.centres[to] = t_.centres[from];
            for (const int beside : t_.cells[to].neighbours)
                for (int& back : t_.cells[beside].neighbours)
                    if (back == from)
                        back = to;
        };
        std::size_t gap = 0, last_gap = gaps_.size();
        int finite = t_.finite_cells, total = int(t_.cells.size());
        while (gap < last_gap)
        {
            --finite;
            if (gaps_[last_gap - 1] == finite)
                --last_gap;
            else
                move(finite, gaps_[gap++]);
        }
        for (int place = finite; place < t_.finite_cells && total > t_.finite_cells; ++place)
            move(--total, place);
        const std::size_t infinite = t_.cells.size() - std::size_t(t_.finite_cells);
        t_.cells.resize(std::size_t(finite) + infinite);
        t_.centres.resize(std::size_t(finite));
        t_.finite_cells = finite;
    }

private:
    struct Facet
    {
        SidedFacet facet; ///< As the cell at the removed vertex sees it.
        int outside;
    };

    const Facet* find_on_hull(const SidedFacet& facet) const
    {
        const auto at = std::lower_bound(hull_.begin(), hull_.end(), facet,
                                         [](const Facet& f, const SidedFacet& key) { return f.facet < key; });
        return at != hull_.end() && at->facet == facet ? &*at : nullptr;
    }

    /// Delaunay cells of the star's own vertices, and which of them fill the hole.
    struct Filling
    {
        Triangulation local;
        std::vector<int> inside; ///< Cells of `local`, ascending.
        std::vector<std::array<const Facet*, 4>>
            hulls; ///< Per cell of `local`, if it is inside: its facets on the hull.
    };

    /// Replaces the star of v.
    Outcome fill(int v)
    {
        std::sort(star_.begin(), star_.end());
        const std::optional<Filling> filling = find_filling();
        if (!filling)
            return Outcome::failed;
        if (filling->inside.size() > star_.size() + gaps_.size())
        {
            for (const int c : star_)
                mark_[c] = none;
            return Outcome::out_of_cells;
        }
        join(*filling, take_places(*filling));
        cell_of_[v] = none;
        return Outcome::removed;
    }

    /// None if the hull of the hole is not among the facets of the cells.
    std::optional<Filling> find_filling() const
    {
        // In the order of the indices, on which ties depend.
        Points points;
        std::vector<double> weights;
        for (const int i : link_)
        {
            points.push_back(points_[i]);
            weights.push_back(weights_[i]);
        }
        std::vector<int> all(link_.size());
        std::iota(all.begin(), all.end(), 0);
        Filling filling{RegularTriangulation(points, weights, all, 1, {}).flatten(points, weights, 1), {}, {}};
        const Triangulation& local = filling.local;
        const auto find_hull = [&](int c, int i)
        {
            std::array<int, 4> vertices = local.cells[c].vertices;
            for (int& w : vertices)
                w = w == Triangulation::infinite ? w : link_[w];
            return find_on_hull(facet_opposite(vertices, i));
        };

        // From a cell at the hull: the flood stops there.
        std::vector<int>& inside = filling.inside;
        std::vector<char> is_inside(local.cells.size(), 0);
        filling.hulls.resize(local.cells.size());
        const auto visit = [&](int c)
        {
            if (is_inside[c])
                return;
            is_inside[c] = 1;
            inside.push_back(c);
        };
        for (int c = 0; c < local.finite_cells && inside.empty(); ++c)
            for (int i = 0; i < 4; ++i)
                if (find_hull(c, i) != nullptr)
                    visit(c);
        std::size_t facets = 0;
        for (std::size_t k = 0; k < inside.size(); ++k)
            for (int i = 0; i < 4; ++i)
            {
                const int c = inside[k];
                if (!local.is_finite(c))
                    return {};
                const Facet* hull = filling.hulls[c][i] = find_hull(c, i);
                if (hull != nullptr)
                    ++facets;
                else
                    visit(local.cells[c].neighbours[i]);
            }
        std::sort(inside.begin(), inside.end());
        return facets == hull_.size() ? std::optional(std::move(filling)) : std::nullopt;
    }

    /// Numbers for the cells inside, as per cell of `local`: those of the star, then gaps; what is left becomes gaps.
    std::vector<int> take_places(const Filling& filling)
    {
        std::vector<int> place(filling.local.cells.size(), none);
        for (std::size_t k = 0; k < filling.inside.size(); ++k)
        {
            int& own = place[filling.inside[k]];
            if (k < star_.size())
                own = star_[k];
            else
            {
                own = gaps_.back();
                gaps_.pop_back();
            }
        }
        for (std::size_t k = filling.inside.size(); k < star_.size(); ++k)
            gaps_.push_back(star_[k]);
        return place;
    }

    /// \param place per cell of `local`.
    void join(const Filling& filling, const std::vector<int>& place)
    {
        // Neighbours outside learn of the new cells only after all have been asked.
        for (const int c : filling.inside)
        {
            const Triangulation::Cell& from = filling.local.cells[c];
            Triangulation::Cell& cell = t_.cells[place[c]];
            t_.centres[place[c]] = filling.local.centres[c];
            mark_[place[c]] = none;
            for (int i = 0; i < 4; ++i)
            {
                cell.vertices[i] = link_[from.vertices[i]];
                if (cell_of_[cell.vertices[i]] != none)
                    cell_of_[cell.vertices[i]] = place[c];
                const Facet* hull = filling.hulls[c][i];
                cell.neighbours[i] = hull != nullptr ? hull->outside : place[from.neighbours[i]];
                if (hull == nullptr)
                    continue;
                // A cell outside may touch the hole with several facets: the vertex across tells which.
                Triangulation::Cell& beside = t_.cells[hull->outside];
                for (int k = 0; k < 4; ++k)
                    if (std::find(hull->facet.vertices.begin(), hull->facet.vertices.end(), beside.vertices[k]) ==
                        hull->facet.vertices.end())
                        beside.neighbours[k] = place[c];
            }
        }
    }

    Triangulation& t_;
    const Points& points_;
    const std::vector<double>& weights_;
    std::vector<int>
        cell_of_;           ///< Per vertex that leaves one of its cells; `none` for the others, and when it has left.
    std::vector<int> mark_; ///< Per cell the vertex in whose star it was seen last.
    std::vector<int> star_, link_;
    std::vector<Facet> hull_;
    std::vector<int> gaps_; ///< Cells that are no more.
};

} // namespace

bool remove_sites(Triangulation& triangulation, const Points& points, const std::vector<double>& weights,
                  const std::vector<int>& removed)
{
    Remover remover(triangulation, points, weights, removed);
    for (std::vector<int> left = removed; !left.empty();)
    {
        std::vector<int> put_off;
        for (const int v : left)
        {
            const Remover::Outcome outcome = remover.remove(v);
            if (outcome == Remover::Outcome::failed)
                return false;
            if (outcome == Remover::Outcome::out_of_cells)
                put_off.push_back(v);
        }
        if (put_off.size() == left.size())
            return false;
        left.swap(put_off);
    }
    remover.close_gaps();
    return true;
}

} // namespace recon
