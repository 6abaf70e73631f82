#include <recon/triangulation/triangulation.h>

#include <recon/parallel.h>

namespace recon
{
namespace
{

/// For the directed edge i -> j of a positively oriented cell: the position of the vertex across whose facet the next
/// cell around the edge lies, counter-clockwise seen from j.
constexpr int next_around_edge[4][4] = {{5, 2, 3, 1}, {3, 5, 0, 2}, {1, 3, 5, 0}, {2, 0, 1, 5}};

/// The next cell after `cell` around the edge from vertex a to vertex b.
int next_in_ring(const Triangulation::Cell& cell, int a, int b)
{
    return cell.neighbours[next_around_edge[cell.position_of(a)][cell.position_of(b)]];
}

} // namespace

bool Triangulation::list_ring_from_lowest(int cell, int a, int b, std::vector<int>& ring) const
{
    ring.clear();
    int c = cell;
    do
    {
        if (c < cell || c >= finite_cells)
            return false;
        ring.push_back(c);
        c = next_in_ring(cells[c], a, b);
    } while (c != cell);
    return true;
}

std::vector<char> mark_vertices(const Triangulation& triangulation, int point_count)
{
    std::vector<char> is_vertex(std::size_t(point_count), 0);
    for (const auto& cell : triangulation.cells)
        for (const int v : cell.vertices)
            if (v != Triangulation::infinite)
                is_vertex[v] = 1;
    return is_vertex;
}

CellsAtVertices list_cells_at_vertices(const Triangulation& triangulation, int vertex_count, int threads)
{
    // Each thread reads all cells and keeps what belongs to its vertices.
    const auto for_all = [&](auto&& call)
    {
        parallel_shares(std::size_t(vertex_count), threads,
                        [&](const Share& own)
                        {
                            // The infinite vertex, being negative, is nobody's.
                            for (std::size_t c = 0; c < triangulation.cells.size(); ++c)
                                for (const int v : triangulation.cells[c].vertices)
                                    if (own.has(v))
                                        call(v, int(c));
                        });
    };
    CellsAtVertices result;
    result.first.assign(std::size_t(vertex_count) + 1, 0);
    for_all([&](int v, int) { ++result.first[v + 1]; });
    for (int v = 0; v < vertex_count; ++v)
        result.first[v + 1] += result.first[v];
    result.cell.resize(result.first.back());
    std::vector<int> next(result.first.begin(), result.first.end() - 1);
    for_all([&](int v, int c) { result.cell[next[v]++] = c; });
    return result;
}

} // namespace recon
