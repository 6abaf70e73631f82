#pragma once

#include <recon/mesh/triangle_tree.h>

#include <memory>
#include <utility>
#include <vector>

namespace recon
{

/// Finds which triangles of a mesh cut those that have a vertex that may move, wherever these vertices are.
class TriangleCuts
{
public:
    /// \param may_move per vertex; the others stay where they are in `mesh`, which must outlive this object.
    /// \param threads >= 1.
    TriangleCuts(const TriangleMesh& mesh, const std::vector<char>& may_move, int threads);

    /// Triangles with a vertex that may move, ascending.
    const std::vector<int>& moving() const { return moving_; }

    /// Pairs of triangles, at least one of them moving, that meet other than in corners and sides that they share; each
    /// pair once, ascending. Neighbours across a side never count, nor does what has no area. \param places of all
    /// vertices.
    std::vector<std::pair<int, int>> list(const Points& places) const;

    /// Per moving triangle, how many triangles it so meets.
    std::vector<int> count(const Points& places) const;

private:
    const TriangleMesh& mesh_;
    int threads_;
    std::vector<int> moving_, held_triangles_;
    TriangleTree::Triangles moving_corners_, held_corners_;
    std::unique_ptr<const TriangleTree> held_;
};

} // namespace recon
