#pragma once

#include <recon/triangulation.h>

#include <algorithm>
#include <vector>

namespace recon
{

/// Copies a CGAL triangulation whose vertices and cells carry an int as info() into flat arrays, without the centres.
/// Finite cells are numbered by their lowest vertex: where the points are in a spatial order, so are the cells then, and
/// walks stay in the cache. For the translation units that instantiate CGAL only.
template <class CgalTriangulation>
Triangulation flatten_triangulation(CgalTriangulation& source, std::size_t point_count)
{
    const auto lowest_vertex = [](auto cell)
    {
        return std::min(std::min(cell->vertex(0)->info(), cell->vertex(1)->info()),
                        std::min(cell->vertex(2)->info(), cell->vertex(3)->info()));
    };
    std::vector<int> next(point_count + 1, 0);
    for (auto c = source.finite_cells_begin(); c != source.finite_cells_end(); ++c)
        ++next[std::size_t(lowest_vertex(c)) + 1];
    for (std::size_t v = 0; v < point_count; ++v)
        next[v + 1] += next[v];
    Triangulation flat;
    flat.finite_cells = next[point_count];
    int number = flat.finite_cells;
    for (auto c = source.all_cells_begin(); c != source.all_cells_end(); ++c)
        c->info() = source.is_infinite(c) ? number++ : next[std::size_t(lowest_vertex(c))]++;
    flat.cells.resize(std::size_t(number));
    for (auto c = source.all_cells_begin(); c != source.all_cells_end(); ++c)
    {
        Triangulation::Cell& cell = flat.cells[std::size_t(c->info())];
        for (int i = 0; i < 4; ++i)
        {
            cell.vertices[i] = source.is_infinite(c->vertex(i)) ? Triangulation::infinite : c->vertex(i)->info();
            cell.neighbours[i] = c->neighbor(i)->info();
        }
    }
    return flat;
}

} // namespace recon
