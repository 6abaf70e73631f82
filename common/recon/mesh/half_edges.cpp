#include <recon/mesh/half_edges.h>

#include <recon/parallel.h>

#include <algorithm>

namespace recon
{

HalfEdges pair_half_edges(const TriangleMesh& mesh, int threads)
{
    const auto& triangles = mesh.triangles;
    std::vector<int> first(mesh.vertices.size() + 1, 0);
    HalfEdges result;
    std::vector<int>& degree = result.degree;
    degree.assign(mesh.vertices.size(), 0);
    result.outgoing.assign(mesh.vertices.size(), -1);
    // Each thread reads all triangles and keeps what belongs to its vertices.
    const auto for_all = [&](auto&& call)
    {
        parallel_shares(mesh.vertices.size(), threads,
                        [&](const Share& own)
                        {
                            for (int t = 0; t < int(triangles.size()); ++t)
                                for (int k = 0; k < 3; ++k)
                                    call(4 * t + k, triangles[t][k], triangles[t][k == 2 ? 0 : k + 1], own);
                        });
    };
    for_all(
        [&](int h, int a, int b, const Share& own)
        {
            if (own.has(std::min(a, b)))
                ++first[std::min(a, b) + 1];
            if (!own.has(a))
                return;
            ++degree[a];
            result.outgoing[a] = h;
        });
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
        first[v + 1] += first[v];
    struct Side
    {
        int half_edge, upper;
        bool rises; ///< Whether it leads from the lower end to the upper.
    };
    std::vector<Side> at_lower(3 * triangles.size());
    std::vector<int> next(first.begin(), first.end() - 1);
    for_all(
        [&](int h, int a, int b, const Share& own)
        {
            if (own.has(std::min(a, b)))
                at_lower[next[std::min(a, b)]++] = {h, std::max(a, b), a < b};
        });

    result.twin.assign(triangles.size(), {-1, -1, -1, -1});
    result.faulty = parallel_collect<int>(
        mesh.vertices.size(), threads, {},
        [&](std::size_t v, std::vector<int>& faulty)
        {
            for (int i = first[v]; i < first[v + 1]; ++i)
            {
                const Side& own = at_lower[i];
                int along = 0, back = 0, twin = -1;
                for (int j = first[v]; j < first[v + 1]; ++j)
                {
                    const Side& other = at_lower[j];
                    if (other.upper != own.upper)
                        continue;
                    ++(other.rises == own.rises ? along : back);
                    if (other.rises != own.rises)
                        twin = other.half_edge;
                }
                result.twin[own.half_edge >> 2][own.half_edge & 3] = twin;
                if (along != 1 || back != 1 || own.upper == int(v) || degree[v] < 3 || degree[own.upper] < 3)
                    faulty.push_back(own.half_edge >> 2);
            }
        },
        8192);
    return result;
}

} // namespace recon
