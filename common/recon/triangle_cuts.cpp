#include <recon/triangle_cuts.h>

#include <recon/parallel.h>

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <array>
#include <iterator>

namespace recon
{
namespace
{

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Corners = std::array<int, 3>;

} // namespace

/// Some triangles of a mesh in a search tree.
class TriangleCuts::Tree
{
public:
    /// \param places of the vertices. Keeps a reference to `triangles`.
    Tree(const Points& places, const std::vector<Corners>& triangles, const std::vector<int>& chosen)
        : triangles_(triangles)
    {
        for (const int t : chosen)
            if (const Kernel::Triangle_3 shape = shape_of(t, places); !shape.is_degenerate())
            {
                shapes_.push_back(shape);
                indices_.push_back(t);
            }
        tree_.rebuild(shapes_.cbegin(), shapes_.cend());
        tree_.build(); // not at the first query, of which several threads may make one
    }

    /// How many of them cross triangle t, other than in corners and sides that they share with it. \param places of its
    /// vertices; those of the tree's triangles are where they were.
    int count_crossing(int t, const Points& places) const
    {
        const Kernel::Triangle_3 shape = shape_of(t, places);
        if (shapes_.empty() || shape.is_degenerate())
            return 0;
        std::vector<Shapes::const_iterator> met;
        tree_.all_intersected_primitives(shape, std::back_inserter(met));
        return int(std::count_if(met.begin(), met.end(),
                                 [&](const Shapes::const_iterator& m)
                                 { return cross(t, indices_[std::size_t(m - shapes_.cbegin())], places); }));
    }

private:
    using Shapes = std::vector<Kernel::Triangle_3>;
    using Primitive = CGAL::AABB_triangle_primitive<Kernel, Shapes::const_iterator>;

    static Kernel::Point_3 to_cgal(const Point& p) { return {p.x(), p.y(), p.z()}; }
    Kernel::Triangle_3 shape_of(int t, const Points& places) const
    {
        const Corners& corners = triangles_[t];
        return {to_cgal(places[corners[0]]), to_cgal(places[corners[1]]), to_cgal(places[corners[2]])};
    }
    /// The side of triangle t opposite to its corner k.
    Kernel::Segment_3 side_of(int t, int k, const Points& places) const
    {
        return {to_cgal(places[triangles_[t][(k + 1) % 3]]), to_cgal(places[triangles_[t][(k + 2) % 3]])};
    }

    /// \pre their shapes meet.
    bool cross(int t, int u, const Points& places) const
    {
        int shared = 0, i = 0, k = 0;
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b)
                if (triangles_[t][a] == triangles_[u][b])
                {
                    ++shared;
                    i = a;
                    k = b;
                }
        if (shared != 1)
            return shared == 0;
        return CGAL::do_intersect(side_of(t, i, places), shape_of(u, places)) ||
               CGAL::do_intersect(side_of(u, k, places), shape_of(t, places));
    }

    const std::vector<Corners>& triangles_;
    Shapes shapes_;
    std::vector<int> indices_; ///< Of the shapes' triangles.
    CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>> tree_;
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
    held_ = std::make_unique<Tree>(mesh.vertices, mesh.triangles, held);
}

TriangleCuts::~TriangleCuts() = default;

std::vector<int> TriangleCuts::count(const Points& places) const
{
    constexpr std::size_t grain = 16;
    const Tree moved(places, mesh_.triangles, moving_);
    std::vector<int> result(moving_.size());
    parallel_for(
        moving_.size(), threads_, {},
        [&](std::size_t i)
        { result[i] = held_->count_crossing(moving_[i], places) + moved.count_crossing(moving_[i], places); },
        grain);
    return result;
}

} // namespace recon
