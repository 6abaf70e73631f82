#include <recon/power_diagram.h>

#include <recon/flatten_triangulation.h>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Exact_rational.h>
#include <CGAL/Regular_triangulation_3.h>
#include <CGAL/Regular_triangulation_cell_base_3.h>
#include <CGAL/Regular_triangulation_vertex_base_3.h>
#include <CGAL/Spatial_sort_traits_adapter_3.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <CGAL/property_map.h>
#include <CGAL/spatial_sort.h>

#include <cmath>
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
        const std::array<Point, 4> corners = {r.centres[v[0]], r.centres[v[1]], r.centres[v[2]], r.centres[v[3]]};
        const std::array<double, 4> weights = {r.weights[v[0]], r.weights[v[1]], r.weights[v[2]], r.weights[v[3]]};
        if (!find_power_centre(corners, weights, flat.centres[c]))
            flat.centres[c] = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
    }
    return flat;
}

namespace
{

/// Offset of the power centre from the first corner by Cramer's rule, in numbers of type Number.
/// \param edges from the first corner to the other three; \param right |edge|^2 + weight of the first - weight of the other.
/// \returns the determinant, by which `offset` is already divided unless it is 0.
template <class Number>
Number solve_power_centre(const Number (&edges)[3][3], const Number (&right)[3], Number (&offset)[3])
{
    const auto minor = [&](int i, int j, int a, int b) -> Number
    { return edges[i][a] * edges[j][b] - edges[i][b] * edges[j][a]; };
    const Number determinant =
        edges[0][0] * minor(1, 2, 1, 2) - edges[0][1] * minor(1, 2, 0, 2) + edges[0][2] * minor(1, 2, 0, 1);
    for (int k = 0; k < 3 && determinant != 0; ++k)
    {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        offset[k] = (right[0] * minor(1, 2, a, b) + right[1] * minor(2, 0, a, b) + right[2] * minor(0, 1, a, b)) /
                    (2 * determinant);
    }
    return determinant;
}

template <class Number>
Number solve_power_centre(const Points& centres, const std::vector<double>& weights, const std::array<int, 4>& v,
                          Number (&offset)[3])
{
    Number edges[3][3], right[3];
    for (int i = 0; i < 3; ++i)
    {
        right[i] = Number(weights[v[0]]) - Number(weights[v[i + 1]]);
        for (int k = 0; k < 3; ++k)
        {
            edges[i][k] = Number(centres[v[i + 1]][k]) - Number(centres[v[0]][k]);
            right[i] += edges[i][k] * edges[i][k];
        }
    }
    return solve_power_centre(edges, right, offset);
}

} // namespace

Point PowerDiagram::exact_centre(const Triangulation::Cell& cell) const
{
    const Regular& r = *regular_;
    const auto& v = cell.vertices;
    Point centre = r.centres[v[0]];
    // 113 bits settle all but a few; rationals are fifty times slower.
    __float128 quick[3] = {};
    const double determinant = double(solve_power_centre(r.centres, r.weights, v, quick));
    double size = 1;
    for (int i = 1; i < 4; ++i)
        size *= (r.centres[v[i]] - r.centres[v[0]]).norm();
    if (std::abs(determinant) > 1e-24 * size)
        return centre + Vector(double(quick[0]), double(quick[1]), double(quick[2]));
    CGAL::Exact_rational exact[3] = {0, 0, 0};
    solve_power_centre(r.centres, r.weights, v, exact);
    return centre + Vector(CGAL::to_double(exact[0]), CGAL::to_double(exact[1]), CGAL::to_double(exact[2]));
}

} // namespace recon
