#include <recon/triangle_cuts.h>

#include <recon/parallel.h>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

namespace recon
{
namespace
{

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

struct Shape
{
    Kernel::Triangle_3 triangle;
    std::array<int, 3> corners; ///< Vertices of the mesh.
    int index;                  ///< Of the triangle, in the list that was chosen.
};

using ShapeBox = CGAL::Box_intersection_d::Box_with_handle_d<double, 3, const Shape*>;

Kernel::Point_3 to_cgal(const Point& p)
{
    return {p.x(), p.y(), p.z()};
}

/// Whether the side opposite to corner k meets the other triangle, in whose plane that corner lies.
bool side_meets(const Kernel::Triangle_3& triangle, int k, const Kernel::Triangle_3& other)
{
    const Kernel::Point_3 &p = triangle[(k + 1) % 3], &q = triangle[(k + 2) % 3];
    const auto side = CGAL::orientation(other[0], other[1], other[2], p);
    if (side != CGAL::COPLANAR && side == CGAL::orientation(other[0], other[1], other[2], q))
        return false; // the most frequent case, for less
    return CGAL::do_intersect(Kernel::Segment_3(p, q), other);
}

bool cross(const Shape& a, const Shape& b)
{
    int shared = 0, i = 0, k = 0;
    for (int m = 0; m < 3; ++m)
        for (int n = 0; n < 3; ++n)
            if (a.corners[m] == b.corners[n])
            {
                ++shared;
                i = m;
                k = n;
            }
    if (shared == 0)
        return CGAL::do_intersect(a.triangle, b.triangle);
    return shared == 1 && (side_meets(a.triangle, i, b.triangle) || side_meets(b.triangle, k, a.triangle));
}

} // namespace

/// Those of some triangles that have an area, and their boxes.
class TriangleCuts::Shapes
{
public:
    /// \param places of the vertices.
    Shapes(const Points& places, const TriangleMesh& mesh, const std::vector<int>& chosen)
    {
        for (std::size_t i = 0; i < chosen.size(); ++i)
        {
            const auto& corners = mesh.triangles[chosen[i]];
            const Kernel::Triangle_3 triangle(to_cgal(places[corners[0]]), to_cgal(places[corners[1]]),
                                              to_cgal(places[corners[2]]));
            if (!triangle.is_degenerate())
                list.push_back({triangle, corners, int(i)});
        }
        for (const Shape& shape : list)
            boxes.emplace_back(shape.triangle.bbox(), &shape);
    }

    std::vector<Shape> list;
    std::vector<ShapeBox> boxes; ///< Of the list, in any order.
};

TriangleCuts::TriangleCuts(const TriangleMesh& mesh, const std::vector<char>& may_move, int threads)
    : mesh_(mesh), threads_(threads)
{
    Points corners;
    std::vector<char> moves(mesh.triangles.size(), 0);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    {
        const auto& [a, b, c] = mesh.triangles[t];
        if (!may_move[a] && !may_move[b] && !may_move[c])
            continue;
        moves[t] = 1;
        moving_.push_back(int(t));
        corners.insert(corners.end(), {mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]});
    }
    const Box reached = bounding_box(corners);
    std::vector<int> held;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    {
        const auto& [a, b, c] = mesh.triangles[t];
        const Box box = bounding_box({mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]});
        if (!moves[t] && (box.minimum.array() <= reached.maximum.array()).all() &&
            (box.maximum.array() >= reached.minimum.array()).all())
            held.push_back(int(t));
    }
    held_ = std::make_unique<Shapes>(mesh.vertices, mesh, held);
}

TriangleCuts::~TriangleCuts() = default;

std::vector<int> TriangleCuts::count(const Points& places) const
{
    Shapes moved(places, mesh_, moving_);
    std::vector<ShapeBox> held = held_->boxes;
    std::vector<std::pair<const Shape*, const Shape*>> pairs; // the first one moves
    const auto collect = [&](const ShapeBox& a, const ShapeBox& b) { pairs.emplace_back(a.handle(), b.handle()); };
    CGAL::box_intersection_d(moved.boxes.begin(), moved.boxes.end(), held.begin(), held.end(), collect);
    const std::size_t with_held = pairs.size();
    CGAL::box_self_intersection_d(moved.boxes.begin(), moved.boxes.end(), collect);
    std::vector<char> crosses(pairs.size());
    parallel_for(pairs.size(), threads_, {},
                 [&](std::size_t i) { crosses[i] = cross(*pairs[i].first, *pairs[i].second); });
    std::vector<int> result(moving_.size());
    for (std::size_t i = 0; i < pairs.size(); ++i)
        if (crosses[i])
        {
            ++result[pairs[i].first->index];
            if (i >= with_held)
                ++result[pairs[i].second->index];
        }
    return result;
}

} // namespace recon
