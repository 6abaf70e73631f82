#include <recon/half_edges.h>

#include <recon/parallel.h>

#include <algorithm>

namespace recon
{

HalfEdges pair_half_edges(const TriangleMesh& mesh, int threads)
{
    const auto& triangles = mesh.triangles;
    std::vector<int> first(mesh.vertices.size() + 1, 0), at_lower(3 * triangles.size()), degree(mesh.vertices.size(), 0);
    const auto for_all = [&](auto&& call)
    {
        for (int t = 0; t < int(triangles.size()); ++t)
            for (int k = 0; k < 3; ++k)
                call(4 * t + k, triangles[t][k], triangles[t][k == 2 ? 0 : k + 1]);
    };
    for_all(
        [&](int, int a, int b)
        {
            ++first[std::min(a, b) + 1];
            ++degree[a];
        });
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
        first[v + 1] += first[v];
    std::vector<int> next(first.begin(), first.end() - 1);
    for_all([&](int h, int a, int b) { at_lower[next[std::min(a, b)]++] = h; });

    HalfEdges result;
    result.twin.assign(triangles.size(), {-1, -1, -1, -1});
    const auto twin = [&](int h) -> int& { return result.twin[h >> 2][h & 3]; };
    const auto origin = [&](int h) { return triangles[h >> 2][h & 3]; };
    const auto target = [&](int h) { return triangles[h >> 2][(h & 3) == 2 ? 0 : (h & 3) + 1]; };
    constexpr std::size_t grain = 8192;
    std::vector<std::vector<int>> faulty((mesh.vertices.size() + grain - 1) / grain);
    parallel_chunks(mesh.vertices.size(), threads, grain, {},
                    [&](std::size_t begin, std::size_t end)
                    {
                        for (std::size_t v = begin; v < end; ++v)
                            for (int i = first[v]; i < first[v + 1]; ++i)
                            {
                                const int g = at_lower[i];
                                int along = 0, back = 0;
                                for (int j = first[v]; j < first[v + 1]; ++j)
                                {
                                    const int h = at_lower[j];
                                    along += origin(h) == origin(g) && target(h) == target(g);
                                    if (origin(h) == target(g) && target(h) == origin(g))
                                    {
                                        ++back;
                                        twin(g) = h;
                                    }
                                }
                                if (along != 1 || back != 1 || origin(g) == target(g) || degree[origin(g)] < 3)
                                    faulty[begin / grain].push_back(g >> 2);
                            }
                    });
    for (const auto& chunk : faulty)
        result.faulty.insert(result.faulty.end(), chunk.begin(), chunk.end());
    return result;
}

} // namespace recon
