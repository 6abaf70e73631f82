#include <recon/triangulation/regular_triangulation.h>

#include <algorithm>

namespace recon
{

RegularTriangulation::Outcome RegularTriangulation::insert(int site, Worker& worker)
{
    Outcome outcome = Outcome::inserted;
    worker.conflicts.clear();
    worker.others.clear();
    const int first = locate(site, worker);
    if (first == none || !own_for_test(first, worker))
        outcome = Outcome::put_off;
    else if (!is_in_conflict(cells_[first], site))
        outcome = Outcome::hidden;
    else if (!find_conflicts(site, first, worker))
        outcome = Outcome::put_off;
    else if (!find_fresh_cells(worker))
        outcome = Outcome::out_of_cells;
    else
        fill_hole(site, worker);
    for (const int c : worker.conflicts)
        marks_[c] = 0;
    for (const int c : worker.others)
        marks_[c] = 0;
    disown(worker);
    return outcome;
}

/// Makes the worker the cell's owner. \returns false if it has another.
bool RegularTriangulation::own(int cell, Worker& worker)
{
    if (worker.owner == nobody)
        return true;
    std::uint8_t owner = owners_[cell].load(std::memory_order_relaxed);
    if (owner == worker.owner)
        return true;
    if (owner != nobody || !owners_[cell].compare_exchange_strong(owner, worker.owner, std::memory_order_acquire))
        return false;
    worker.owned.push_back(cell);
    return true;
}

void RegularTriangulation::disown(Worker& worker)
{
    for (const int c : worker.owned)
        owners_[c].store(nobody, std::memory_order_release);
    worker.owned.clear();
}

/// Walks from the hint to a cell that contains the site, or to an infinite one that sees it; `none` if a cell on the
/// way has another owner.
int RegularTriangulation::locate(int site, Worker& worker)
{
    int c = worker.hint, previous = none;
    // Another thread may have taken it out, or used it anew.
    while (!own(c, worker) || cells_[c].vertices[0] == dead)
        c = (c + 1) % used_;
    if (is_infinite(cells_[c]))
    {
        previous = c;
        c = cells_[c].neighbours[cells_[c].position_of(Triangulation::infinite)];
        if (!own(c, worker))
            return none;
    }
    for (;;)
    {
        const Cell& cell = cells_[c];
        if (is_infinite(cell))
            return c;
        worker.random = worker.random * 1664525u + 1013904223u;
        const int start = int(worker.random >> 30);
        int next = none;
        for (int k = 0; k < 4 && next == none; ++k)
        {
            const int i = (start + k) & 3;
            if (cell.neighbours[i] != previous && find_orientation_with(cell, i, site) < 0)
                next = cell.neighbours[i];
        }
        if (next == none)
            return c;
        if (!own(next, worker))
            return none;
        previous = c;
        c = next;
    }
}

/// Makes the worker the owner of what is_in_conflict() reads.
bool RegularTriangulation::own_for_test(int cell, Worker& worker)
{
    if (!own(cell, worker))
        return false;
    const Cell& c = cells_[cell];
    return worker.owner == nobody || !is_infinite(c) ||
           own(c.neighbours[c.position_of(Triangulation::infinite)], worker);
}

/// Lists and marks the cells in conflict with the site, and the hull of them. \returns false if a cell has another
/// owner.
bool RegularTriangulation::find_conflicts(int site, int first, Worker& worker)
{
    worker.conflicts.push_back(first);
    worker.hull.clear();
    marks_[first] = 1;
    for (std::size_t k = 0; k < worker.conflicts.size(); ++k)
    {
        const Cell& cell = cells_[worker.conflicts[k]];
        for (int i = 0; i < 4; ++i)
        {
            const int beside = cell.neighbours[i];
            if (!own_for_test(beside, worker))
                return false;
            int& mark = marks_[beside];
            if (mark == 0 && is_in_conflict(cells_[beside], site))
            {
                worker.conflicts.push_back(beside);
                mark = int(worker.conflicts.size());
                for (const int next : cells_[beside].neighbours)
                {
                    __builtin_prefetch(&cells_[next]);
                    __builtin_prefetch(&marks_[next]);
                }
            }
            else if (mark == 0)
            {
                worker.others.push_back(beside);
                mark = -1;
            }
            if (mark < 0)
                worker.hull.push_back({int(k), i});
        }
    }
    return true;
}

bool RegularTriangulation::find_fresh_cells(Worker& worker)
{
    worker.fresh.clear();
    std::size_t tried = 0;
    // One that a thread looks at as its hint has to wait.
    while (worker.fresh.size() < worker.hull.size() && tried < worker.free.size())
    {
        const std::size_t at = worker.free.size() - 1 - tried;
        if (own(worker.free[at], worker))
        {
            worker.fresh.push_back(worker.free[at]);
            worker.free.erase(worker.free.begin() + std::ptrdiff_t(at));
        }
        else
            ++tried;
    }
    while (worker.fresh.size() < worker.hull.size() && (worker.unused_begin < worker.unused_end || take_slab(worker)))
    {
        worker.fresh.push_back(worker.unused_begin++);
        own(worker.fresh.back(), worker);
    }
    if (worker.fresh.size() == worker.hull.size())
        return true;
    worker.free.insert(worker.free.end(), worker.fresh.begin(), worker.fresh.end());
    for (const int c : worker.fresh)
        cells_[c].vertices[0] = dead;
    return false;
}

/// Makes unused cells the worker's, if there are any left.
bool RegularTriangulation::take_slab(Worker& worker)
{
    constexpr int slab = 1024;
    const int end = int(marks_.size());
    if (&worker == &serial_ || next_slab_.load(std::memory_order_relaxed) >= end)
        return false;
    worker.unused_begin = next_slab_.fetch_add(slab, std::memory_order_relaxed);
    worker.unused_end = std::min(worker.unused_begin + slab, end);
    return worker.unused_begin < end;
}

/// Replaces the conflicts by cells from the site to their hull.
void RegularTriangulation::fill_hole(int site, Worker& worker)
{
    for (std::size_t k = 0; k < worker.hull.size(); ++k)
    {
        const auto [conflict, facet] = worker.hull[k];
        const int made = worker.fresh[k], old = worker.conflicts[conflict];
        Cell& cell = cells_[made];
        cell.vertices = cells_[old].vertices;
        cell.vertices[facet] = site;
        const int beside = cells_[old].neighbours[facet];
        cell.neighbours[facet] = beside;
        cells_[beside].neighbours[cells_[beside].position_across(old)] = made;
        if (!is_infinite(cell))
            worker.hint = made;
    }
    join_along_edges(worker);
    if (&worker == &serial_)
        used_ = worker.unused_begin;
    for (const int c : worker.conflicts)
    {
        cells_[c].vertices[0] = dead;
        worker.free.push_back(c);
    }
}

/// Makes new cells at facets side by side on the hull neighbours. In two passes, since whether a facet is the first at
/// an edge is nothing that a processor could predict.
void RegularTriangulation::join_along_edges(Worker& worker)
{
    // A hull of f facets has 3 f directed edges.
    if (worker.edges.size() < 6 * worker.hull.size())
    {
        std::size_t size = 512;
        while (size < 12 * worker.hull.size())
            size *= 2;
        worker.edges.assign(size, {});
        worker.fills = 0;
    }
    if (++worker.fills == 0)
    {
        worker.edges.assign(worker.edges.size(), {});
        worker.fills = 1;
    }
    const unsigned mask = unsigned(worker.edges.size()) - 1;
    // All 32 bits count: a point amid a million on a sphere sees them all, more than the upper 20 bits tell apart.
    const auto place = [](int from, int to)
    {
        const unsigned product = (unsigned(from) * 0x9e3779b1u + unsigned(to)) * 0x85ebca6bu;
        return product ^ product >> 12;
    };
    // Opposite positions 0 to 3 of a positively oriented cell the others, counter-clockwise seen from there.
    constexpr int around[4][3] = {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}};
    for (std::size_t k = 0; k < worker.hull.size(); ++k)
    {
        const auto& v = cells_[worker.fresh[k]].vertices;
        const auto& ring = around[worker.hull[k][1]];
        for (int i = 0; i < 3; ++i)
        {
            const int from = v[ring[i]], to = v[ring[i == 2 ? 0 : i + 1]];
            unsigned at = place(from, to) & mask;
            while (worker.edges[at].fill == worker.fills)
                at = (at + 1) & mask;
            worker.edges[at] = {worker.fills, from, to, int(k)};
        }
    }
    for (std::size_t k = 0; k < worker.hull.size(); ++k)
    {
        Cell& cell = cells_[worker.fresh[k]];
        const auto& ring = around[worker.hull[k][1]];
        for (int i = 0; i < 3; ++i)
        {
            const int from = cell.vertices[ring[i]], to = cell.vertices[ring[i == 2 ? 0 : i + 1]];
            unsigned at = place(to, from) & mask;
            while (worker.edges[at].from != to || worker.edges[at].to != from)
                at = (at + 1) & mask;
            cell.neighbours[ring[i == 0 ? 2 : i - 1]] = worker.fresh[worker.edges[at].facet];
        }
    }
}

/// Orientation of the cell with the site in the place of one of its vertices.
int RegularTriangulation::find_orientation_with(const Cell& c, int position, int site) const
{
    std::array<int, 4> v = c.vertices;
    v[position] = site;
    return find_orientation(sites_[v[0]], sites_[v[1]], sites_[v[2]], sites_[v[3]]);
}

bool RegularTriangulation::is_in_conflict(const Cell& c, int site) const
{
    const auto& v = c.vertices;
    if (is_infinite(c))
    {
        const int i = c.position_of(Triangulation::infinite);
        const int orientation = find_orientation_with(c, i, site);
        // In the plane of the facet the sphere of the cell behind it decides, which meets the plane in the facet's
        // circle.
        return orientation != 0 ? orientation > 0 : is_in_conflict(cells_[c.neighbours[i]], site);
    }
    const int side = find_power_side(sites_[v[0]], sites_[v[1]], sites_[v[2]], sites_[v[3]], sites_[site]);
    return side != 0 ? side > 0 : is_in_perturbed_conflict(c, site);
}

/// The sign of the power side if the weight of each site were larger by an infinitesimal, that of lower indices by one
/// infinitely larger: a heavier new site is in conflict; a heavier vertex moves the sphere away from the new site where
/// its barycentric coordinate there is positive, towards it where that is negative.
bool RegularTriangulation::is_in_perturbed_conflict(const Cell& c, int site) const
{
    std::array<int, 4> order{0, 1, 2, 3};
    std::sort(order.begin(), order.end(),
              [&](int i, int j) { return indices_[c.vertices[i]] < indices_[c.vertices[j]]; });
    for (const int i : order)
    {
        if (indices_[site] < indices_[c.vertices[i]])
            return true;
        const int coordinate = find_orientation_with(c, i, site);
        if (coordinate != 0)
            return coordinate < 0;
    }
    return true;
}

} // namespace recon
