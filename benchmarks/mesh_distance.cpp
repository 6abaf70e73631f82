#include "mesh_distance.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <boost/variant.hpp>

#include <cmath>
#include <variant>

namespace benchmarks
{
namespace
{

using Kernel = CGAL::Simple_cartesian<double>;
using Triangle = Kernel::Triangle_3;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, std::vector<Triangle>::const_iterator>;
using Aabb = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Kernel::Point_3 to_cgal(const recon::Point& p)
{
    return {p.x(), p.y(), p.z()};
}

// What a ray meets: a point or a segment, in CGAL 5 as boost::variant, in CGAL 6 as std::variant.
template <class... Met>
const Kernel::Point_3* point_of(const boost::variant<Met...>& met)
{
    return boost::get<Kernel::Point_3>(&met);
}
template <class... Met>
const Kernel::Point_3* point_of(const std::variant<Met...>& met)
{
    return std::get_if<Kernel::Point_3>(&met);
}

} // namespace

struct MeshDistance::Tree
{
    std::vector<Triangle> triangles;
    std::vector<int> index; // of the mesh's triangle
    Aabb aabb;
};

MeshDistance::MeshDistance(const recon::TriangleMesh& mesh) : tree_(std::make_unique<Tree>())
{
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        const auto& t = mesh.triangles[i];
        const Triangle triangle(to_cgal(mesh.vertices[t[0]]), to_cgal(mesh.vertices[t[1]]),
                                to_cgal(mesh.vertices[t[2]]));
        if (triangle.is_degenerate())
            continue;
        tree_->triangles.push_back(triangle);
        tree_->index.push_back(int(i));
    }
    tree_->aabb.insert(tree_->triangles.begin(), tree_->triangles.end());
    tree_->aabb.accelerate_distance_queries();
}

MeshDistance::~MeshDistance() = default;

MeshDistance::Nearest MeshDistance::nearest(const recon::Point& query) const
{
    const auto found = tree_->aabb.closest_point_and_primitive(to_cgal(query));
    const recon::Point point(found.first.x(), found.first.y(), found.first.z());
    return {(query - point).norm(), point, tree_->index[std::size_t(found.second - tree_->triangles.cbegin())]};
}

MeshDistance::Nearest MeshDistance::first_hit(const recon::Point& origin, const recon::Vector& direction) const
{
    const auto hit = tree_->aabb.first_intersection(Kernel::Ray_3(to_cgal(origin), to_cgal(origin + direction)));
    const Kernel::Point_3* at = hit ? point_of(hit->first) : nullptr;
    if (!at)
        return {0, origin, -1};
    const recon::Point point(at->x(), at->y(), at->z());
    return {(point - origin).norm(), point, tree_->index[std::size_t(hit->second - tree_->triangles.cbegin())]};
}

MeshDistance::Summary MeshDistance::summarise(const recon::Points& points) const
{
    double squares = 0, largest = 0;
    for (const recon::Point& p : points)
    {
        const double d = nearest(p).distance;
        squares += d * d;
        largest = std::max(largest, d);
    }
    return {points.empty() ? 0 : std::sqrt(squares / double(points.size())), largest};
}

} // namespace benchmarks
