#include <recon/mismatch.h>

#include <recon/neighbours.h>
#include <recon/parallel.h>

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <vector>

namespace recon
{
namespace
{

using Kernel = CGAL::Simple_cartesian<double>;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

/// Points so near to the surface may be noise, where it is known [its standard deviation].
constexpr double beyond_noise = 5;
constexpr std::size_t most_asked = 20'000, most_asked_of_area = 4'000;

Kernel::Point_3 to_cgal(const Point& p)
{
    return {p.x(), p.y(), p.z()};
}

double measure_missed_points(const Points& points, const TriangleMesh& mesh, const NeighbourSearch& search,
                             double noise, int threads, const Progress& progress)
{
    Triangles triangles;
    for (const auto& t : mesh.triangles)
    {
        triangles.emplace_back(to_cgal(mesh.vertices[t[0]]), to_cgal(mesh.vertices[t[1]]),
                               to_cgal(mesh.vertices[t[2]]));
        if (triangles.back().is_degenerate())
            triangles.pop_back();
    }
    if (triangles.empty())
        return 1;
    Tree tree(triangles.cbegin(), triangles.cend());
    tree.accelerate_distance_queries();
    const std::size_t stride = points.size() / most_asked + 1, asked = (points.size() + stride - 1) / stride;
    std::vector<char> is_missed(asked);
    parallel_for(asked, threads, progress,
                 [&](std::size_t i)
                 {
                     const Point& p = points[i * stride];
                     const double reach = std::max(measure_spacing_at(p, search), beyond_noise * noise);
                     is_missed[i] = tree.squared_distance(to_cgal(p)) > reach * reach;
                 });
    return double(std::count(is_missed.begin(), is_missed.end(), 1)) / double(asked);
}

double measure_bare_area(const Points& points, const TriangleMesh& mesh, const NeighbourSearch& search, int threads,
                         const Progress& progress)
{
    std::vector<double> area_up_to;
    double area = 0;
    for (const auto& t : mesh.triangles)
    {
        const Point &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        area_up_to.push_back(area += (b - a).cross(c - a).norm());
    }
    if (!(area > 0))
        return 0;
    // At equal steps of area: a lid is a few large triangles among thousands of small ones.
    const std::size_t asked = std::min(mesh.triangles.size(), most_asked_of_area);
    std::vector<char> is_bare(asked);
    parallel_for(asked, threads, progress,
                 [&](std::size_t i)
                 {
                     const double at = area * ((double(i) + 0.5) / double(asked));
                     const auto found = std::lower_bound(area_up_to.begin(), area_up_to.end() - 1, at);
                     const auto& t = mesh.triangles[std::size_t(found - area_up_to.begin())];
                     const Point centre = (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3;
                     const Point& nearest = points[search.nearest(centre)];
                     is_bare[i] = (centre - nearest).norm() > bare_beyond * measure_spacing_at(nearest, search);
                 });
    return double(std::count(is_bare.begin(), is_bare.end(), 1)) / double(asked);
}

} // namespace

Mismatch measure_mismatch(const Points& points, const TriangleMesh& mesh, int threads, const Progress& progress)
{
    Mismatch result;
    if (points.empty())
        return result;
    const NeighbourSearch search(points);
    result.missed_points = measure_missed_points(points, mesh, search, 0, threads, progress.part(0, 0.5, "points"));
    result.bare_area = measure_bare_area(points, mesh, search, threads, progress.part(0.5, 1, "area"));
    return result;
}

double measure_missed_points(const Points& points, const TriangleMesh& mesh, int threads, const Progress& progress,
                             double noise)
{
    return points.empty() ? 0 : measure_missed_points(points, mesh, NeighbourSearch(points), noise, threads, progress);
}

double measure_bare_area(const Points& points, const TriangleMesh& mesh, int threads, const Progress& progress)
{
    return points.empty() ? 0 : measure_bare_area(points, mesh, NeighbourSearch(points), threads, progress);
}

} // namespace recon
