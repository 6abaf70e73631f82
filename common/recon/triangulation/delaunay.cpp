#include <recon/triangulation/delaunay.h>

#include <recon/triangulation/regular_triangulation.h>

#include <numeric>

namespace recon
{

Triangulation triangulate_delaunay(const Points& points, const Progress& progress, int threads)
{
    std::vector<int> all(points.size());
    std::iota(all.begin(), all.end(), 0);
    return RegularTriangulation(points, {}, all, threads, progress).flatten(points, {}, threads);
}

} // namespace recon
