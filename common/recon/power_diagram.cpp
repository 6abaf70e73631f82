#include <recon/power_diagram.h>

#include <recon/flatten_triangulation.h>
#include <recon/power_centre.h>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Regular_triangulation_3.h>
#include <CGAL/Regular_triangulation_cell_base_3.h>
#include <CGAL/Regular_triangulation_vertex_base_3.h>
#include <CGAL/Spatial_sort_traits_adapter_3.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <CGAL/property_map.h>
#include <CGAL/spatial_sort.h>

#include <cstdint>
#include <numeric>

namespace recon
{
namespace
{

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<int, Kernel, CGAL::Regular_triangulation_vertex_base_3<Kernel>>;
using CellBase = CGAL::Triangulation_cell_base_with_info_3<
    int, Kernel,
    CGAL::Regular_triangulation_cell_base_3<Kernel, CGAL::Triangulation_cell_base_3<Kernel>, CGAL::Discard_hidden_points>>;
using CgalRegular = CGAL::Regular_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;

/// Uniform in [0, 1), a fixed function of the index (splitmix64).
double pseudo_random(std::uint64_t index)
{
    std::uint64_t z = (index + 1) * 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return double((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

} // namespace

struct PowerDiagram::Regular
{
    Points centres;
    std::vector<double> weights;
    CgalRegular triangulation;
    std::vector<CgalRegular::Vertex_handle> vertex; ///< Of each ball; null where the ball is hidden or removed.
};

PowerDiagram::PowerDiagram(const std::vector<Ball>& balls, const Progress& progress) : regular_(std::make_unique<Regular>())
{
    Regular& r = *regular_;
    std::vector<Kernel::Point_3> sites;
    sites.reserve(balls.size());
    r.centres.reserve(balls.size());
    r.weights.reserve(balls.size());
    for (std::size_t i = 0; i < balls.size(); ++i)
    {
        const Ball& ball = balls[i];
        r.centres.push_back(ball.centre);
        r.weights.push_back(ball.radius * ball.radius * (1 - 1e-9 * pseudo_random(i)));
        sites.emplace_back(ball.centre.x(), ball.centre.y(), ball.centre.z());
    }
    std::vector<std::size_t> order(balls.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    using SiteOf = CGAL::Pointer_property_map<Kernel::Point_3>::type;
    CGAL::spatial_sort(order.begin(), order.end(),
                       CGAL::Spatial_sort_traits_adapter_3<Kernel, SiteOf>(CGAL::make_property_map(sites)));

    CgalRegular::Cell_handle hint;
    for (std::size_t i = 0; i < order.size(); ++i)
    {
        if (i % 4096 == 0)
            progress.report(double(i) / double(order.size()));
        const std::size_t ball = order[i];
        const auto vertex =
            r.triangulation.insert(Kernel::Weighted_point_3(sites[ball], r.weights[ball]), hint);
        if (vertex == CgalRegular::Vertex_handle()) // hidden
            continue;
        vertex->info() = int(ball);
        hint = vertex->cell();
    }
    r.vertex.resize(balls.size());
    for (auto v = r.triangulation.finite_vertices_begin(); v != r.triangulation.finite_vertices_end(); ++v)
        r.vertex[std::size_t(v->info())] = v;
}

PowerDiagram::~PowerDiagram() = default;
PowerDiagram::PowerDiagram(PowerDiagram&&) noexcept = default;

void PowerDiagram::remove(const std::vector<int>& balls)
{
    for (const int ball : balls)
    {
        auto& vertex = regular_->vertex[std::size_t(ball)];
        if (vertex != CgalRegular::Vertex_handle())
            regular_->triangulation.remove(vertex);
        vertex = CgalRegular::Vertex_handle();
    }
}

Triangulation PowerDiagram::triangulation() const
{
    const Regular& r = *regular_;
    Triangulation flat = flatten_triangulation(regular_->triangulation, r.centres.size());
    flat.centres.resize(std::size_t(flat.finite_cells));
    for (int c = 0; c < flat.finite_cells; ++c)
    {
        const auto& v = flat.cells[c].vertices;
        flat.centres[c] = find_power_centre({r.centres[v[0]], r.centres[v[1]], r.centres[v[2]], r.centres[v[3]]},
                                            {r.weights[v[0]], r.weights[v[1]], r.weights[v[2]], r.weights[v[3]]});
    }
    return flat;
}

} // namespace recon
