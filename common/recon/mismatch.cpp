#include <recon/mismatch.h>

#include <recon/neighbours.h>
#include <recon/parallel.h>

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <Eigen/Geometry>

#include <cmath>
#include <vector>

namespace recon
{
namespace
{

using Kernel = CGAL::Simple_cartesian<double>;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

constexpr std::size_t most_asked = 20'000;

Kernel::Point_3 to_cgal(const Point& p)
{
    return {p.x(), p.y(), p.z()};
}

/// Every n-th, so that at most `most_asked` are.
std::size_t stride_through(std::size_t count)
{
    return count / most_asked + 1;
}

double measure_spacing_at(const Point& p, const NeighbourSearch& search)
{
    constexpr int around = 7; // the point itself is the first
    int indices[around];
    double squared[around], sum = 0;
    const int found = search.nearest(p, around, indices, squared);
    for (int k = 1; k < found; ++k)
        sum += std::sqrt(squared[k]);
    return found > 1 ? sum / (found - 1) : 0;
}

double measure_missed_points(const Points& points, const TriangleMesh& mesh, const NeighbourSearch& search, int threads,
                             const Progress& progress)
{
    Triangles triangles;
    for (const auto& t : mesh.triangles)
    {
        triangles.emplace_back(to_cgal(mesh.vertices[t[0]]), to_cgal(mesh.vertices[t[1]]), to_cgal(mesh.vertices[t[2]]));
        if (triangles.back().is_degenerate())
            triangles.pop_back();
    }
    if (triangles.empty())
        return 1;
    Tree tree(triangles.cbegin(), triangles.cend());
    tree.accelerate_distance_queries();
    const std::size_t stride = stride_through(points.size()), asked = (points.size() + stride - 1) / stride;
    std::vector<char> is_missed(asked);
    parallel_for(asked, threads, progress,
                 [&](std::size_t i)
                 {
                     const Point& p = points[i * stride];
                     const double spacing = measure_spacing_at(p, search);
                     is_missed[i] = tree.squared_distance(to_cgal(p)) > spacing * spacing;
                 });
    double missed = 0;
    for (const char is : is_missed)
        missed += is;
    return missed / double(asked);
}

double measure_bare_area(const Points& points, const TriangleMesh& mesh, const NeighbourSearch& search, int threads,
                         const Progress& progress)
{
    constexpr double reach = 2; // spacings
    const std::size_t stride = stride_through(mesh.triangles.size()), asked = (mesh.triangles.size() + stride - 1) / stride;
    std::vector<double> area(asked);
    std::vector<char> is_bare(asked);
    parallel_for(asked, threads, progress,
                 [&](std::size_t i)
                 {
                     const auto& t = mesh.triangles[i * stride];
                     const Point &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
                     area[i] = (b - a).cross(c - a).norm();
                     const Point centre = (a + b + c) / 3;
                     const Point& nearest = points[search.nearest(centre)];
                     is_bare[i] = (centre - nearest).norm() > reach * measure_spacing_at(nearest, search);
                 });
    double sum = 0, bare = 0;
    for (std::size_t i = 0; i < asked; ++i)
    {
        sum += area[i];
        bare += is_bare[i] ? area[i] : 0;
    }
    return sum > 0 ? bare / sum : 0;
}

} // namespace

Mismatch measure_mismatch(const Points& points, const TriangleMesh& mesh, int threads, const Progress& progress)
{
    Mismatch result;
    if (points.empty())
        return result;
    const NeighbourSearch search(points);
    result.missed_points = measure_missed_points(points, mesh, search, threads, progress.part(0, 0.5, "points"));
    result.bare_area = measure_bare_area(points, mesh, search, threads, progress.part(0.5, 1, "area"));
    return result;
}

} // namespace recon
