#pragma once

#include <recon/geometry.h>

#include <memory>

namespace benchmarks
{

/// Exact distances to a triangle mesh (CGAL's AABB tree): the ground truth of every RMS figure.
class MeshDistance
{
public:
    explicit MeshDistance(const recon::TriangleMesh& mesh);
    ~MeshDistance();

    struct Nearest
    {
        double distance;
        recon::Point point;
        int triangle;
    };
    Nearest nearest(const recon::Point& query) const;
    /// Where a ray first meets the mesh; none: the index is -1.
    Nearest first_hit(const recon::Point& origin, const recon::Vector& direction) const;

    /// Root mean square distance of `points` to the mesh, and the largest [input units].
    struct Summary
    {
        double rms, largest;
    };
    Summary summarise(const recon::Points& points) const;

private:
    struct Tree;
    std::unique_ptr<Tree> tree_;
};

} // namespace benchmarks
