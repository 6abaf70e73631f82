#pragma once

#include <recon/triangle_tree.h>

#include <memory>
#include <vector>

namespace recon
{

/// Counts how many triangles of a mesh cut those that have a vertex that may move, wherever these vertices are.
class TriangleCuts
{
public:
    /// \param may_move per vertex; the others stay where they are in `mesh`, which must outlive this object.
    /// \param threads >= 1.
    TriangleCuts(const TriangleMesh& mesh, const std::vector<char>& may_move, int threads);

    /// Triangles with a vertex that may move, ascending.
    const std::vector<int>& moving() const { return moving_; }

    /// Per moving triangle, the number of triangles that it meets other than in corners and sides that they share.
    /// Neighbours across a side never count, nor does what has no area. \param places of all vertices.
    std::vector<int> count(const Points& places) const;

private:
    const TriangleMesh& mesh_;
    int threads_;
    std::vector<int> moving_;
    TriangleTree::Triangles moving_corners_, held_corners_;
    std::unique_ptr<const TriangleTree> held_;
};

} // namespace recon
