#include "crust_normals.h"

#include <recon/crust/crust.h>
#include <recon/parallel.h>
#include <recon/search/block_search.h>

#include <Eigen/Geometry>

namespace recon
{
namespace
{

/// Those around a fold agree among themselves: their mean is at least so long. At the edge of a plate it is shorter.
constexpr double agreeing = 0.5;

/// After Max 1999.
Vectors weigh_by_sides(const TriangleMesh& mesh)
{
    return sum_corner_normals(mesh,
                              [&](const std::array<int, 3>& t, int k) -> Vector
                              {
                                  const Point& corner = mesh.vertices[t[k]];
                                  const Vector a = mesh.vertices[t[(k + 1) % 3]] - corner,
                                               b = mesh.vertices[t[(k + 2) % 3]] - corner;
                                  const double lengths = a.squaredNorm() * b.squaredNorm();
                                  return lengths > 0 ? Vector(a.cross(b) / lengths) : Vector::Zero();
                              });
}

} // namespace

Vectors sum_corner_normals(const TriangleMesh& mesh,
                           const std::function<Vector(const std::array<int, 3>&, int)>& at_corner)
{
    Vectors normals(mesh.vertices.size(), Vector::Zero());
    for (const auto& t : mesh.triangles)
        for (int k = 0; k < 3; ++k)
            normals[t[k]] += at_corner(t, k);
    for (Vector& normal : normals)
        normal.normalize(); // that leaves zero vectors
    Vectors around(normals.size(), Vector::Zero());
    std::vector<int> corners(normals.size());
    for (const auto& t : mesh.triangles)
        for (int k = 0; k < 3; ++k)
        {
            around[t[k]] += normals[t[(k + 1) % 3]];
            ++corners[t[k]];
        }
    for (std::size_t v = 0; v < normals.size(); ++v)
        if (normals[v].dot(around[v]) <= 0 && around[v].norm() > agreeing * corners[v])
            normals[v] = around[v].normalized();
    return normals;
}

CrustNormals list_crust_normals(const Points& samples, const LabelledBalls& labelled, int threads,
                                const Progress& progress)
{
    CrustOptions options;
    options.target_vertices = int(samples.size());
    options.interpolated = &samples;
    options.threads = threads;
    CrustNormals result;
    result.crust = make_crust(labelled, options, progress);
    const Vectors vertex_normals = weigh_by_sides(result.crust);
    const BlockSearch search(result.crust.vertices);
    result.normals.resize(samples.size());
    result.distances.resize(samples.size());
    parallel_for(
        samples.size(), threads, {},
        [&](std::size_t i)
        {
            const auto v = std::size_t(search.nearest(samples[i]));
            result.normals[i] = vertex_normals[v];
            result.distances[i] = (result.crust.vertices[v] - samples[i]).norm();
        },
        1024);
    return result;
}

} // namespace recon
