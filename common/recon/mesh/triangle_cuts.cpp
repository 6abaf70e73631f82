#include <recon/mesh/triangle_cuts.h>

#include <recon/parallel.h>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <array>

namespace recon
{
namespace
{

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

using Corners = std::array<int, 3>;

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

Kernel::Triangle_3 to_cgal(const Corners& corners, const Points& places)
{
    return {to_cgal(places[corners[0]]), to_cgal(places[corners[1]]), to_cgal(places[corners[2]])};
}

/// Whether one meets the other elsewhere than in corners and sides that they share.
bool cross(const Corners& a, const Corners& b, const Points& places)
{
    int shared = 0, i = 0, k = 0;
    for (int m = 0; m < 3; ++m)
        for (int n = 0; n < 3; ++n)
            if (a[m] == b[n])
            {
                ++shared;
                i = m;
                k = n;
            }
    if (shared > 1)
        return false;
    const Kernel::Triangle_3 first = to_cgal(a, places), second = to_cgal(b, places);
    if (first.is_degenerate() || second.is_degenerate())
        return false;
    return shared == 0 ? CGAL::do_intersect(first, second)
                       : side_meets(first, i, second) || side_meets(second, k, first);
}

} // namespace

TriangleCuts::TriangleCuts(const TriangleMesh& mesh, const std::vector<char>& may_move, int threads)
    : mesh_(mesh), threads_(threads)
{
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    {
        const auto& [a, b, c] = mesh.triangles[t];
        if (may_move[a] || may_move[b] || may_move[c])
        {
            moving_.push_back(int(t));
            moving_corners_.push_back(mesh.triangles[t]);
        }
        else
        {
            held_triangles_.push_back(int(t));
            held_corners_.push_back(mesh.triangles[t]);
        }
    }
    held_ = std::make_unique<TriangleTree>(mesh.vertices, held_corners_);
}

std::vector<std::pair<int, int>> TriangleCuts::list(const Points& places) const
{
    const TriangleTree moved(places, moving_corners_);
    std::vector<std::pair<int, int>> result = parallel_collect<std::pair<int, int>>(
        moving_.size(), threads_, {},
        [&](std::size_t i, std::vector<std::pair<int, int>>& met)
        {
            const Corners& own = moving_corners_[i];
            const Box box = bounding_box({places[own[0]], places[own[1]], places[own[2]]});
            held_->visit_near(box,
                              [&](int k)
                              {
                                  if (cross(own, held_corners_[k], places))
                                      met.push_back(std::minmax(moving_[i], held_triangles_[k]));
                              });
            moved.visit_near(box,
                             [&](int k)
                             {
                                 if (std::size_t(k) > i && cross(own, moving_corners_[k], places))
                                     met.push_back({moving_[i], moving_[k]});
                             });
        });
    std::sort(result.begin(), result.end());
    return result;
}

std::vector<int> TriangleCuts::count(const Points& places) const
{
    std::vector<int> of_triangle(mesh_.triangles.size(), 0), result;
    for (const auto& [a, b] : list(places))
    {
        ++of_triangle[a];
        ++of_triangle[b];
    }
    for (const int t : moving_)
        result.push_back(of_triangle[t]);
    return result;
}

} // namespace recon
