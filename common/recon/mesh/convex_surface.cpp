#include <recon/mesh/convex_surface.h>

#include <recon/median.h>
#include <recon/search/neighbours.h>

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <utility>
#include <vector>

namespace recon
{
namespace
{

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<int, Kernel>;
using Delaunay = CGAL::Delaunay_triangulation_3<
    Kernel, CGAL::Triangulation_data_structure_3<VertexBase, CGAL::Delaunay_triangulation_cell_base_3<Kernel>>>;

/// As far as single precision moves points off a face [diagonal].
constexpr double rounding = 1e-6;

using Corners = std::array<int, 3>;

/// Edges within a flat face are diagonals. \param deep what still counts as flat.
void mark_diagonals(TriangleMesh& hull, double deep)
{
    std::map<std::pair<int, int>, int> opposite; // to a triangle's side, in its direction
    for (const Corners& t : hull.triangles)
        for (int k = 0; k < 3; ++k)
            opposite[{t[k], t[(k + 1) % 3]}] = t[(k + 2) % 3];
    for (const Corners& t : hull.triangles)
    {
        hull.faux_edges.push_back(0);
        const Point& a = hull.vertices[t[0]];
        const Vector normal = (hull.vertices[t[1]] - a).cross(hull.vertices[t[2]] - a).normalized();
        for (int k = 0; k < 3; ++k)
        {
            const int beyond = opposite.at({t[(k + 1) % 3], t[k]});
            const Vector across = (hull.vertices[beyond] - a);
            if (std::abs(normal.dot(across)) <= deep)
                hull.faux_edges.back() |= std::uint8_t(1 << k);
        }
    }
}

/// Whether a vertex has diagonals only.
bool has_vertices_within_faces(const TriangleMesh& hull)
{
    std::vector<char> is_on_edge(hull.vertices.size(), 0);
    for (std::size_t i = 0; i < hull.triangles.size(); ++i)
        for (int k = 0; k < 3; ++k)
            if ((hull.faux_edges[i] >> k & 1) == 0)
                is_on_edge[std::size_t(hull.triangles[i][k])] =
                    is_on_edge[std::size_t(hull.triangles[i][(k + 1) % 3])] = 1;
    return std::count(is_on_edge.begin(), is_on_edge.end(), 0) > 0;
}

/// How deep a point lies within a convex mesh.
double measure_depth(const Point& p, const TriangleMesh& hull)
{
    double depth = std::numeric_limits<double>::infinity();
    for (const Corners& t : hull.triangles)
    {
        const Point& a = hull.vertices[t[0]];
        const Vector normal = (hull.vertices[t[1]] - a).cross(hull.vertices[t[2]] - a);
        if (const double area = normal.norm(); area > 0)
            depth = std::min(depth, normal.dot(a - p) / area);
    }
    return depth;
}

} // namespace

std::optional<ConvexSurface> find_convex_surface(const Points& points)
{
    if (points.size() < 4 || points.size() > most_points_on_hull)
        return {};
    const UnitFrame frame(points);
    std::vector<std::pair<Kernel::Point_3, int>> numbered;
    for (std::size_t i = 0; i < points.size(); ++i)
    {
        const Point p = frame.to_unit(points[i]);
        numbered.emplace_back(Kernel::Point_3(p.x(), p.y(), p.z()), int(i));
    }
    const Delaunay delaunay(numbered.begin(), numbered.end());
    if (delaunay.dimension() < 3)
        return {};
    ConvexSurface result;
    TriangleMesh& hull = result.mesh;
    std::vector<int> vertex_of(points.size(), -1);
    std::vector<Delaunay::Cell_handle> outside;
    delaunay.incident_cells(delaunay.infinite_vertex(), std::back_inserter(outside));
    for (const Delaunay::Cell_handle& cell : outside)
    {
        const int infinite = cell->index(delaunay.infinite_vertex());
        Corners corners;
        for (int k = 0; k < 3; ++k) // counter-clockwise as seen from the infinite vertex
        {
            const int i = cell->vertex(Delaunay::vertex_triple_index(infinite, k))->info();
            if (vertex_of[std::size_t(i)] < 0)
            {
                vertex_of[std::size_t(i)] = int(hull.vertices.size());
                hull.vertices.push_back(frame.to_unit(points[std::size_t(i)]));
                result.points.push_back(i);
            }
            corners[std::size_t(k)] = vertex_of[std::size_t(i)];
        }
        hull.triangles.push_back(corners);
    }
    const double deep = rounding * bounding_box(hull.vertices).diagonal();
    for (auto v = delaunay.finite_vertices_begin(); v != delaunay.finite_vertices_end(); ++v)
        if (vertex_of[std::size_t(v->info())] < 0)
        {
            if (measure_depth(frame.to_unit(points[std::size_t(v->info())]), hull) > deep)
                return {};
            result.has_points_within_faces = true;
        }
    mark_diagonals(hull, deep);
    result.has_points_within_faces |= has_vertices_within_faces(hull);
    hull.vertices = points_at(result.points, points);
    const NeighbourSearch search(hull.vertices);
    std::vector<double> spacings;
    for (const Point& p : hull.vertices)
        spacings.push_back(measure_spacing_at(p, search));
    result.spacing = median(std::move(spacings));
    return result;
}

} // namespace recon
