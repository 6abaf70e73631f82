#include "pn_models.h"

#include "tests/shapes.h"

#include <recon/parallel.h>
#include <recon/search/neighbours.h>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace benchmarks
{

using namespace recon;

namespace
{

std::vector<double> areas_summed(const TriangleMesh& mesh)
{
    std::vector<double> sums;
    double sum = 0;
    for (const auto& t : mesh.triangles)
    {
        const Point& a = mesh.vertices[std::size_t(t[0])];
        sum += 0.5 * (mesh.vertices[std::size_t(t[1])] - a).cross(mesh.vertices[std::size_t(t[2])] - a).norm();
        sums.push_back(sum);
    }
    return sums;
}

using shapes::uniform;

} // namespace

double surface_area(const TriangleMesh& mesh)
{
    return areas_summed(mesh).back();
}

OrientedSamples sample_mesh(const TriangleMesh& mesh, int n, std::uint64_t seed)
{
    Vectors normals(mesh.vertices.size(), Vector::Zero());
    for (const auto& t : mesh.triangles)
    {
        const Point& a = mesh.vertices[std::size_t(t[0])];
        const Vector normal = (mesh.vertices[std::size_t(t[1])] - a).cross(mesh.vertices[std::size_t(t[2])] - a);
        for (int v : t)
            normals[std::size_t(v)] += normal;
    }
    const std::vector<double> sums = areas_summed(mesh);
    shapes::Random random(seed);
    OrientedSamples samples;
    for (int i = 0; i < n; ++i)
    {
        const auto at = std::lower_bound(sums.begin(), sums.end(), uniform(random) * sums.back());
        const auto& t =
            mesh.triangles[std::size_t(std::min<std::ptrdiff_t>(at - sums.begin(), std::ptrdiff_t(sums.size()) - 1))];
        double u = uniform(random), v = uniform(random);
        if (u + v > 1)
        {
            u = 1 - u;
            v = 1 - v;
        }
        const double w = 1 - u - v;
        samples.points.push_back(w * mesh.vertices[std::size_t(t[0])] + u * mesh.vertices[std::size_t(t[1])] +
                                 v * mesh.vertices[std::size_t(t[2])]);
        samples.normals.push_back((w * normals[std::size_t(t[0])].normalized() +
                                   u * normals[std::size_t(t[1])].normalized() +
                                   v * normals[std::size_t(t[2])].normalized())
                                      .normalized());
    }
    return samples;
}

double largest_gap(const OrientedSamples& surface, const OrientedSamples& cloud, int threads,
                   const std::function<double(const Point&)>& weight)
{
    const NeighbourSearch search(cloud.points);
    std::vector<double> gaps(surface.points.size(), 0);
    parallel_for(surface.points.size(), threads, {},
                 [&](std::size_t i)
                 {
                     constexpr int k = 24;
                     int indices[k];
                     double squared[k];
                     const int found = search.nearest(surface.points[i], k, indices, squared);
                     double least = std::sqrt(squared[found - 1]);
                     for (int m = 0; m < found; ++m)
                     {
                         const auto j = std::size_t(indices[m]);
                         if (cloud.normals[j].dot(surface.normals[i]) <= 0)
                             continue;
                         const Vector d = cloud.points[j] - surface.points[i];
                         least = std::min(least, (d - d.dot(surface.normals[i]) * surface.normals[i]).norm());
                     }
                     gaps[i] = least * weight(surface.points[i]);
                 });
    return *std::max_element(gaps.begin(), gaps.end());
}

OrientedSamples join(const OrientedSamples& input, const PnRefinement& refinement)
{
    OrientedSamples all = input;
    all.points.insert(all.points.end(), refinement.points.begin(), refinement.points.end());
    all.normals.insert(all.normals.end(), refinement.normals.begin(), refinement.normals.end());
    return all;
}

double closest_pair(const OrientedSamples& input, const Points& appended)
{
    Points all = input.points;
    all.insert(all.end(), appended.begin(), appended.end());
    const NeighbourSearch search(all);
    double least = 1e300;
    for (const Point& p : appended)
    {
        int indices[2];
        double squared[2];
        if (search.nearest(p, 2, indices, squared) == 2)
            least = std::min(least, squared[1]);
    }
    return std::sqrt(least);
}

} // namespace benchmarks
