#include "face_cameras.h"

#include <recon/labelling/minimum_cut.h>
#include <recon/labelling/signed_graph.h>
#include <recon/search/block_search.h>

#include <cmath>
#include <vector>

namespace recon
{
namespace
{

constexpr int neighbours = 8;
/// Weight of a neighbour whose normal is the same, beside that of a ray along the normal.
constexpr double of_neighbour = 0.25;

} // namespace

void face_cameras(const Viewpoints& cameras, const Points& points, Vectors& normals, int threads)
{
    SignedGraph graph; // inner: stays, outer: turns
    graph.nodes = int(points.size());
    graph.is_root.assign(points.size(), 0);
    std::vector<TerminalTie> ties;
    const BlockSearch search(points, threads);
    for (int i = 0; i < graph.nodes; ++i)
    {
        const double cosine = normals[i].dot((cameras.of(points[i]) - points[i]).normalized());
        if (cosine != 0)
            ties.push_back({i, cosine > 0 ? Side::inner : Side::outer, std::abs(cosine)});
        int near[neighbours + 1];
        double squared[neighbours + 1];
        const int found = search.nearest(points[i], neighbours + 1, near, squared);
        for (int k = 0; k < found; ++k)
            if (const double agreement = normals[i].dot(normals[near[k]]); near[k] != i && agreement > 0)
                graph.edges.push_back({i, near[k], of_neighbour * agreement});
    }
    const std::vector<Side> sides = label_by_minimum_cut(graph, ties);
    for (std::size_t i = 0; i < normals.size(); ++i)
        if (sides[i] == Side::outer)
            normals[i] = -normals[i];
}

} // namespace recon
