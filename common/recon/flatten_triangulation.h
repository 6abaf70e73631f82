#pragma once

#include <recon/parallel.h>
#include <recon/power_centre.h>
#include <recon/triangulation.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace recon
{

/// A cell of a CGAL triangulation whose vertices and cells carry an int as info(). Vertices ascending but for the last two, which
/// keep the orientation.
template <class CgalTriangulation>
Triangulation::Cell copy_cell(const CgalTriangulation& source, typename CgalTriangulation::Cell_handle handle)
{
    Triangulation::Cell cell;
    for (int i = 0; i < 4; ++i)
    {
        const auto vertex = handle->vertex(i);
        cell.vertices[i] = source.is_infinite(vertex) ? Triangulation::infinite : vertex->info();
        cell.neighbours[i] = handle->neighbor(i)->info();
    }
    bool odd = false;
    const auto exchange = [&](int i, int j)
    {
        std::swap(cell.vertices[i], cell.vertices[j]);
        std::swap(cell.neighbours[i], cell.neighbours[j]);
        odd = !odd;
    };
    for (const auto& [i, j] : {std::pair(0, 1), std::pair(2, 3), std::pair(0, 2), std::pair(1, 3), std::pair(1, 2)})
        if (cell.vertices[i] > cell.vertices[j])
            exchange(i, j);
    if (odd)
        exchange(2, 3);
    return cell;
}

/// Copies a CGAL triangulation whose vertices and cells carry an int as info() into flat arrays, without the centres.
/// Cells, and the vertices within a cell, are numbered by the indices of the points alone: CGAL's own order depends on
/// addresses once a vertex has been removed, so it differs from run to run. Finite cells go by their lowest vertex:
/// where the points are in a spatial order, so are the cells then, and walks stay in the cache (in CGAL's order labels and
/// repair took a third longer). For the translation units that instantiate CGAL only.
/// \param leave_numbers whether info() of the cells shall be their index in the result afterwards.
template <class CgalTriangulation>
Triangulation flatten_triangulation(CgalTriangulation& source, std::size_t point_count, int threads,
                                    bool leave_numbers = false)
{
    using Cell = Triangulation::Cell;
    std::vector<typename CgalTriangulation::Cell_handle> handles;
    handles.reserve(source.tds().cells().size());
    for (auto c = source.all_cells_begin(); c != source.all_cells_end(); ++c)
    {
        c->info() = int(handles.size());
        handles.push_back(c);
    }

    std::vector<Cell> copied(handles.size());
    constexpr std::size_t grain = 8192;
    parallel_for(
        handles.size(), threads, {}, [&](std::size_t i) { copied[i] = copy_cell(source, handles[i]); }, grain);

    // Buckets by the lowest vertex, finite cells first.
    const auto bucket = [&](const Cell& cell)
    {
        const bool finite = cell.vertices[0] != Triangulation::infinite;
        return finite ? std::size_t(cell.vertices[0]) : point_count + std::size_t(cell.vertices[1]);
    };
    std::vector<int> first(2 * point_count + 1, 0);
    for (const Cell& cell : copied)
        ++first[bucket(cell) + 1];
    for (std::size_t b = 0; b < 2 * point_count; ++b)
        first[b + 1] += first[b];
    std::vector<int> order(copied.size()), position(copied.size());
    std::vector<int> next(first.begin(), first.end() - 1);
    for (std::size_t i = 0; i < copied.size(); ++i)
        order[next[bucket(copied[i])]++] = int(i);

    Triangulation flat;
    flat.finite_cells = first[point_count];
    flat.cells.resize(copied.size());
    parallel_for(
        2 * point_count, threads, {},
        [&](std::size_t b)
        {
            std::sort(order.begin() + first[b], order.begin() + first[b + 1],
                      [&](int p, int q) { return copied[p].vertices < copied[q].vertices; });
            for (int k = first[b]; k < first[b + 1]; ++k)
                position[order[k]] = k;
        },
        grain);
    parallel_for(
        copied.size(), threads, {},
        [&](std::size_t k)
        {
            flat.cells[k] = copied[order[k]];
            for (int& neighbour : flat.cells[k].neighbours)
                neighbour = position[neighbour];
            if (leave_numbers)
                handles[order[k]]->info() = int(k);
        },
        grain);
    return flat;
}

/// Fills in the centres. point_of(v) and weight_of(v) give a vertex's position and weight.
template <class PointOf, class WeightOf>
void find_centres(Triangulation& flat, int threads, PointOf&& point_of, WeightOf&& weight_of)
{
    flat.centres.resize(std::size_t(flat.finite_cells));
    parallel_for(
        flat.centres.size(), threads, {},
        [&](std::size_t c)
        {
            const auto& v = flat.cells[c].vertices;
            flat.centres[c] = find_power_centre({point_of(v[0]), point_of(v[1]), point_of(v[2]), point_of(v[3])},
                                                {weight_of(v[0]), weight_of(v[1]), weight_of(v[2]), weight_of(v[3])});
        },
        2048);
}

} // namespace recon
