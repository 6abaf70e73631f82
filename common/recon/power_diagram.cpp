#include <recon/power_diagram.h>

#include <recon/flatten_triangulation.h>
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
using CellBase = CGAL::Triangulation_cell_base_with_info_3<
    int, Kernel,
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
        vertex.assign(centres.size(), CgalRegular::Vertex_handle());
        for (auto v = triangulation.finite_vertices_begin(); v != triangulation.finite_vertices_end(); ++v)
            vertex[std::size_t(v->info())] = v;
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

void PowerDiagram::remove(const std::vector<int>& balls)
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
    if (!rebuild)
        return;
    std::vector<std::size_t> left;
    for (std::size_t i = 0; i < r.vertex.size(); ++i)
        if (r.vertex[i] != CgalRegular::Vertex_handle())
            left.push_back(i);
    r.build(std::move(left), {});
}

Triangulation PowerDiagram::triangulation(int threads) const
{
    const Regular& r = *regular_;
    Triangulation flat = flatten_triangulation(regular_->triangulation, r.centres.size(), threads);
    find_centres(
        flat, threads, [&](int v) -> const Point& { return r.centres[v]; }, [&](int v) { return r.weights[v]; });
    return flat;
}

} // namespace recon
