#pragma once

#include <recon/triangulation.h>

namespace recon
{

/// Copies a CGAL triangulation whose vertices and cells carry an int as info() into flat arrays, without the centres.
/// For the translation units that instantiate CGAL only.
template <class CgalTriangulation>
Triangulation flatten_triangulation(CgalTriangulation& source)
{
    Triangulation flat;
    int finite = 0;
    for (auto c = source.finite_cells_begin(); c != source.finite_cells_end(); ++c)
        c->info() = finite++;
    int next = finite;
    for (auto c = source.all_cells_begin(); c != source.all_cells_end(); ++c)
        if (source.is_infinite(c))
            c->info() = next++;
    flat.finite_cells = finite;
    flat.cells.resize(std::size_t(next));
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
