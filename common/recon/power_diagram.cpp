#include <recon/power_diagram.h>

#include <recon/flatten_triangulation.h>
#include <recon/power_centre.h>
#include <recon/scramble.h>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Regular_triangulation_3.h>
#include <CGAL/Regular_triangulation_cell_base_3.h>
#include <CGAL/Regular_triangulation_vertex_base_3.h>
#include <CGAL/Spatial_sort_traits_adapter_3.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <CGAL/property_map.h>
#include <CGAL/spatial_sort.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>

namespace recon
{
namespace
{

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase =
    CGAL::Triangulation_vertex_base_with_info_3<int, Kernel, CGAL::Regular_triangulation_vertex_base_3<Kernel>>;
/// Index of a cell in the flat triangulation; `unknown` in cells made since.
struct CellNumber
{
    static constexpr int unknown = -1;
    CellNumber(int number = unknown) : value(number) {}
    operator int() const { return value; }
    int value;
};
using CellBase = CGAL::Triangulation_cell_base_with_info_3<
    CellNumber, Kernel,
    CGAL::Regular_triangulation_cell_base_3<Kernel, CGAL::Triangulation_cell_base_3<Kernel>,
                                            CGAL::Discard_hidden_points>>;
using CgalRegular = CGAL::Regular_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;

/// Uniform in [0, 1), a fixed function of the index.
double pseudo_random(std::uint64_t index)
{
    return double(scramble(index * splitmix_step) >> 11) * 0x1p-53;
}

} // namespace

struct PowerDiagram::Regular
{
    Points centres;
    std::vector<double> weights;
    CgalRegular triangulation;
    std::vector<CgalRegular::Vertex_handle> vertex; ///< Of each ball; null where the ball is hidden or removed.

    bool has_numbers = false; ///< Whether the cells know their index in the triangulation given out last.

    Kernel::Point_3 site(std::size_t ball) const { return {centres[ball].x(), centres[ball].y(), centres[ball].z()}; }

    /// Makes the triangulation of these balls.
    void build(std::vector<std::size_t> members, const Progress& progress)
    {
        std::vector<Kernel::Point_3> sites;
        sites.reserve(centres.size());
        for (std::size_t i = 0; i < centres.size(); ++i)
            sites.push_back(site(i));
        using SiteOf = CGAL::Pointer_property_map<Kernel::Point_3>::type;
        CGAL::spatial_sort(members.begin(), members.end(),
                           CGAL::Spatial_sort_traits_adapter_3<Kernel, SiteOf>(CGAL::make_property_map(sites)));
        triangulation.clear();
        CgalRegular::Cell_handle hint;
        for (std::size_t i = 0; i < members.size(); ++i)
        {
            if (i % 4096 == 0)
                progress.report(double(i) / double(members.size()));
            const std::size_t ball = members[i];
            const auto added = triangulation.insert(Kernel::Weighted_point_3(sites[ball], weights[ball]), hint);
            if (added == CgalRegular::Vertex_handle()) // hidden
                continue;
            added->info() = int(ball);
            hint = added->cell();
        }
        has_numbers = false;
        vertex.assign(centres.size(), CgalRegular::Vertex_handle());
        for (auto v = triangulation.finite_vertices_begin(); v != triangulation.finite_vertices_end(); ++v)
            vertex[std::size_t(v->info())] = v;
    }

    /// Replaces the cells that removals have taken out of `flat` by those that fill the holes; moves few others. \returns false,
    /// with nothing changed, where the hull has changed or cells have become more.
    bool replace_cells(Triangulation& flat)
    {
        struct NewCell
        {
            Triangulation::Cell cell;
            CgalRegular::Cell_handle handle;
        };
        std::vector<NewCell> created;
        std::vector<char> is_alive(flat.cells.size(), 0);
        for (auto c = triangulation.all_cells_begin(); c != triangulation.all_cells_end(); ++c)
            if (c->info() == CellNumber::unknown)
                created.push_back({copy_cell(triangulation, c), c});
            else
                is_alive[std::size_t(c->info())] = 1;
        std::vector<int> dead;
        for (int c = 0; c < int(flat.cells.size()); ++c)
            if (!is_alive[std::size_t(c)])
                dead.push_back(c);
        if (dead.size() < created.size() || (!dead.empty() && dead.back() >= flat.finite_cells))
            return false;
        for (const NewCell& c : created)
            if (c.cell.vertices[0] == Triangulation::infinite)
                return false;

        // By their vertices: CGAL's order depends on addresses now.
        std::sort(created.begin(), created.end(),
                  [](const NewCell& a, const NewCell& b) { return a.cell.vertices < b.cell.vertices; });
        for (std::size_t i = 0; i < created.size(); ++i)
            created[i].handle->info() = dead[i];
        for (const NewCell& c : created)
        {
            const int number = c.handle->info();
            const Triangulation::Cell copied = copy_cell(triangulation, c.handle);
            flat.cells[number] = copied;
            const auto& v = copied.vertices;
            flat.centres[number] = find_power_centre({centres[v[0]], centres[v[1]], centres[v[2]], centres[v[3]]},
                                                     {weights[v[0]], weights[v[1]], weights[v[2]], weights[v[3]]});
        }
        // The old cells around a hole learn who fills it, by the vertex across.
        for (const NewCell& c : created)
            for (int i = 0; i < 4; ++i)
            {
                const auto beside = c.handle->neighbor(i);
                const auto across = beside->vertex(beside->index(c.handle));
                Triangulation::Cell& cell = flat.cells[beside->info()];
                const int vertex = triangulation.is_infinite(across) ? Triangulation::infinite : across->info();
                cell.neighbours[cell.position_of(vertex)] = c.handle->info();
            }

        // What is left of the holes is filled from the end of the finite cells, and their end from that of all.
        const auto move = [&](int from, int to)
        {
            flat.cells[to] = flat.cells[from];
            if (to < flat.finite_cells && from < flat.finite_cells)
                flat.centres[to] = flat.centres[from];
            for (const int beside : flat.cells[to].neighbours)
                for (int& back : flat.cells[beside].neighbours)
                    if (back == from)
                        back = to;
        };
        std::size_t hole = created.size(), last_hole = dead.size();
        int finite = flat.finite_cells, total = int(flat.cells.size());
        while (hole < last_hole)
        {
            --finite;
            if (dead[last_hole - 1] == finite)
                --last_hole;
            else
                move(finite, dead[hole++]);
        }
        for (int gap = finite; gap < flat.finite_cells && total > flat.finite_cells; ++gap)
            move(--total, gap);
        flat.cells.resize(std::size_t(finite) + (flat.cells.size() - std::size_t(flat.finite_cells)));
        flat.centres.resize(std::size_t(finite));
        flat.finite_cells = finite;
        has_numbers = false;
        return true;
    }
};

PowerDiagram::PowerDiagram(const std::vector<Ball>& balls, const Progress& progress)
    : regular_(std::make_unique<Regular>())
{
    Regular& r = *regular_;
    r.centres.reserve(balls.size());
    r.weights.reserve(balls.size());
    for (std::size_t i = 0; i < balls.size(); ++i)
    {
        r.centres.push_back(balls[i].centre);
        r.weights.push_back(balls[i].radius * balls[i].radius * (1 - 1e-9 * pseudo_random(i)));
    }
    std::vector<std::size_t> all(balls.size());
    std::iota(all.begin(), all.end(), std::size_t(0));
    r.build(std::move(all), progress);
}

PowerDiagram::~PowerDiagram() = default;
PowerDiagram::PowerDiagram(PowerDiagram&&) noexcept = default;

Triangulation PowerDiagram::triangulation(int threads)
{
    Regular& r = *regular_;
    Triangulation flat = flatten_triangulation(r.triangulation, r.centres.size(), threads, true);
    find_centres(flat, threads, [&](int v) -> const Point& { return r.centres[v]; }, [&](int v) { return r.weights[v]; });
    r.has_numbers = true;
    return flat;
}

void PowerDiagram::remove(const std::vector<int>& balls, Triangulation& current, int threads)
{
    Regular& r = *regular_;
    // Taking one out costs as much as inserting some thirty.
    const bool rebuild = balls.size() > 0.03 * double(r.vertex.size());
    for (const int ball : balls)
    {
        auto& vertex = r.vertex[std::size_t(ball)];
        if (!rebuild && vertex != CgalRegular::Vertex_handle())
            r.triangulation.remove(vertex);
        vertex = CgalRegular::Vertex_handle();
    }
    if (!rebuild && r.has_numbers && r.replace_cells(current))
        return;
    if (rebuild)
    {
        std::vector<std::size_t> left;
        for (std::size_t i = 0; i < r.vertex.size(); ++i)
            if (r.vertex[i] != CgalRegular::Vertex_handle())
                left.push_back(i);
        r.build(std::move(left), {});
    }
    current = triangulation(threads);
}

} // namespace recon
