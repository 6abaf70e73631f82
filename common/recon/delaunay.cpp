#include <recon/delaunay.h>

#include <recon/flatten_triangulation.h>

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_cell_base_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Spatial_sort_traits_adapter_3.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <CGAL/property_map.h>
#include <CGAL/spatial_sort.h>

#include <numeric>

namespace recon
{
namespace
{

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<int, Kernel>;
using CellBase =
    CGAL::Triangulation_cell_base_with_info_3<int, Kernel, CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using Delaunay = CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;

} // namespace

Triangulation triangulate_delaunay(const Points& points, const Progress& progress, int threads)
{
    std::vector<Kernel::Point_3> sites;
    sites.reserve(points.size());
    for (const Point& p : points)
        sites.emplace_back(p.x(), p.y(), p.z());
    std::vector<std::size_t> order(points.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    using SiteOf = CGAL::Pointer_property_map<Kernel::Point_3>::type;
    CGAL::spatial_sort(order.begin(), order.end(),
                       CGAL::Spatial_sort_traits_adapter_3<Kernel, SiteOf>(CGAL::make_property_map(sites)));

    Delaunay delaunay;
    Delaunay::Vertex_handle hint;
    for (std::size_t i = 0; i < order.size(); ++i)
    {
        if (i % 4096 == 0)
            progress.report(double(i) / double(order.size()));
        const std::size_t before = delaunay.number_of_vertices();
        hint = delaunay.insert(sites[order[i]], hint);
        if (delaunay.number_of_vertices() > before)
            hint->info() = int(order[i]);
    }

    Triangulation flat = flatten_triangulation(delaunay, points.size(), threads);
    find_centres(
        flat, threads, [&](int v) -> const Point& { return points[v]; }, [](int) { return 0.0; });
    return flat;
}

} // namespace recon
