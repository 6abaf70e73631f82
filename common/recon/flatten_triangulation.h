#pragma once

#include <recon/triangulation.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace recon
{

/// Copies a CGAL triangulation whose vertices and cells carry an int as info() into flat arrays, without the centres.
/// Cells, and the vertices within a cell, are numbered by the indices of the points alone: CGAL's own order depends on
/// addresses once a vertex has been removed, so it differs from run to run. Finite cells go by their lowest vertex: where
/// the points are in a spatial order, so are the cells then, and walks stay in the cache. For the translation units that
/// instantiate CGAL only.
template <class CgalTriangulation>
Triangulation flatten_triangulation(CgalTriangulation& source, std::size_t point_count)
{
    using CellHandle = typename CgalTriangulation::Cell_handle;
    struct Entry
    {
        std::array<int, 4> vertices; ///< Ascending but for the last two, which keep the orientation.
        CellHandle cell;
    };
    const auto index_of = [&](auto vertex) { return source.is_infinite(vertex) ? Triangulation::infinite : vertex->info(); };
    const auto make_entry = [&](CellHandle cell)
    {
        Entry entry{{index_of(cell->vertex(0)), index_of(cell->vertex(1)), index_of(cell->vertex(2)), index_of(cell->vertex(3))},
                    cell};
        auto& v = entry.vertices;
        bool odd = false;
        for (int end = 3; end > 0; --end)
            for (int i = 0; i < end; ++i)
                if (v[i] > v[i + 1])
                {
                    std::swap(v[i], v[i + 1]);
                    odd = !odd;
                }
        if (odd)
            std::swap(v[2], v[3]);
        return entry;
    };

    // Buckets by the lowest vertex, finite cells first.
    std::vector<std::size_t> first(2 * point_count + 1, 0);
    std::vector<Entry> unordered;
    for (auto c = source.all_cells_begin(); c != source.all_cells_end(); ++c)
        unordered.push_back(make_entry(c));
    const auto bucket = [&](const Entry& entry)
    {
        const bool finite = entry.vertices[0] != Triangulation::infinite;
        return finite ? std::size_t(entry.vertices[0]) : point_count + std::size_t(entry.vertices[1]);
    };
    for (const Entry& entry : unordered)
        ++first[bucket(entry) + 1];
    for (std::size_t b = 0; b < 2 * point_count; ++b)
        first[b + 1] += first[b];
    std::vector<Entry> entries(unordered.size());
    std::vector<std::size_t> next(first.begin(), first.end() - 1);
    for (const Entry& entry : unordered)
        entries[next[bucket(entry)]++] = entry;
    unordered = {};
    for (std::size_t b = 0; b < 2 * point_count; ++b)
        std::sort(entries.begin() + std::ptrdiff_t(first[b]), entries.begin() + std::ptrdiff_t(first[b + 1]),
                  [](const Entry& p, const Entry& q) { return p.vertices < q.vertices; });

    Triangulation flat;
    flat.finite_cells = int(first[point_count]);
    flat.cells.resize(entries.size());
    for (std::size_t i = 0; i < entries.size(); ++i)
        entries[i].cell->info() = int(i);
    for (std::size_t i = 0; i < entries.size(); ++i)
    {
        const Entry& entry = entries[i];
        flat.cells[i].vertices = entry.vertices;
        for (int k = 0; k < 4; ++k)
        {
            int position = 0;
            while (index_of(entry.cell->vertex(position)) != entry.vertices[k])
                ++position;
            flat.cells[i].neighbours[k] = entry.cell->neighbor(position)->info();
        }
    }
    return flat;
}

} // namespace recon
