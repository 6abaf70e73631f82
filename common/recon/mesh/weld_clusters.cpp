#include <recon/mesh/weld_clusters.h>

#include <recon/disjoint_sets.h>
#include <recon/parallel.h>

#include <algorithm>

namespace recon
{
namespace
{

/// Calls call(corner, next corner) around polygon p.
template <class Function>
void for_each_side(const CrustPolygons& polygons, std::size_t p, Function&& call)
{
    const int begin = polygons.first[p], end = polygons.first[p + 1];
    for (int k = begin; k < end; ++k)
        call(polygons.corners[k], polygons.corners[k + 1 < end ? k + 1 : begin]);
}

constexpr std::size_t grain = 8192;

/// Calls call(polygon) for all of them.
template <class Function>
void for_each_polygon(const CrustPolygons& polygons, int threads, Function&& call)
{
    parallel_for(polygons.first.size() - 1, threads, {}, call, grain);
}

/// Per vertex the lowest vertex of its cluster.
std::vector<int> find_clusters(const CrustPolygons& polygons, const std::vector<double>& scale,
                               const NearestSamples* nearest, int threads)
{
    const double length = nearest ? cluster_length_in_cell : cluster_length;
    DisjointSets sets(polygons.vertices.size());
    for_each_polygon(polygons, threads,
                     [&](std::size_t p)
                     {
                         for_each_side(polygons, p,
                                       [&](int a, int b)
                                       {
                                           if (nearest && nearest->sample[a] != nearest->sample[b])
                                               return;
                                           const double reach = length * std::min(scale[a], scale[b]);
                                           if (a < b && (polygons.vertices[a] - polygons.vertices[b]).squaredNorm() <=
                                                            reach * reach)
                                               sets.join(a, b);
                                       });
                     });
    std::vector<int> cluster(polygons.vertices.size());
    parallel_for(
        cluster.size(), threads, {}, [&](std::size_t i) { cluster[i] = sets.find(int(i)); }, grain);
    return cluster;
}

/// Per cluster (at its lowest vertex) vertices - edges + faces.
std::vector<int> count_euler_characteristics(const CrustPolygons& polygons, const std::vector<int>& cluster,
                                             int threads)
{
    std::vector<int> twice(cluster.size(), 0);
    parallel_for(
        cluster.size(), threads, {}, [&](std::size_t i) { fetch_add(twice[cluster[i]], 2); }, grain);
    for_each_polygon(polygons, threads,
                     [&](std::size_t p)
                     {
                         const int own = cluster[polygons.corners[polygons.first[p]]];
                         bool inside = true;
                         for_each_side(polygons, p,
                                       [&](int a, int b)
                                       {
                                           inside = inside && cluster[a] == own;
                                           if (cluster[a] == cluster[b])
                                               fetch_add(twice[cluster[a]], -1);
                                       });
                         if (inside)
                             fetch_add(twice[own], 2);
                     });
    for (int& value : twice)
        value /= 2;
    return twice;
}

/// Makes singles of the vertices whose cluster is bad.
void dissolve(const std::vector<char>& is_bad, std::vector<int>& cluster)
{
    if (std::find(is_bad.begin(), is_bad.end(), 1) == is_bad.end())
        return;
    for (int i = int(cluster.size()) - 1; i >= 0; --i) // a cluster's lowest vertex last
        if (is_bad[cluster[i]])
            cluster[i] = i;
}

/// Per cluster (at its lowest corner) the corner at which it lies.
std::vector<int> place(const std::vector<int>& cluster, const NearestSamples* nearest)
{
    std::vector<int> result = cluster;
    if (nearest)
        for (int i = 0; i < int(cluster.size()); ++i)
            if (int& chosen = result[cluster[i]]; nearest->squared[i] < nearest->squared[chosen])
                chosen = i;
    return result;
}

/// What is left of the corners of each polygon by list(polygon, corners), which appends them; polygons with fewer than
/// three are dropped. Without vertices.
template <class List>
CrustPolygons relist(const CrustPolygons& polygons, int threads, List&& list)
{
    const std::size_t count = polygons.first.size() - 1;
    struct Chunk
    {
        std::vector<int> corners, end;
    };
    std::vector<Chunk> chunks((count + grain - 1) / grain);
    parallel_chunks(count, threads, grain, {},
                    [&](std::size_t begin, std::size_t end)
                    {
                        Chunk& chunk = chunks[begin / grain];
                        chunk.corners.reserve(std::size_t(polygons.first[end] - polygons.first[begin]));
                        for (std::size_t p = begin; p < end; ++p)
                        {
                            const std::size_t start = chunk.corners.size();
                            list(p, chunk.corners);
                            if (chunk.corners.size() < start + 3)
                                chunk.corners.resize(start);
                            else
                                chunk.end.push_back(int(chunk.corners.size()));
                        }
                    });
    CrustPolygons result;
    result.first.reserve(count + 1);
    result.corners.reserve(polygons.corners.size());
    for (const Chunk& chunk : chunks)
    {
        const int before = int(result.corners.size());
        for (const int end : chunk.end)
            result.first.push_back(before + end);
        result.corners.insert(result.corners.end(), chunk.corners.begin(), chunk.corners.end());
    }
    return result;
}

/// The polygons with one vertex per cluster, less those with fewer than three. Vertices keep their numbers.
CrustPolygons contract(const CrustPolygons& polygons, const std::vector<int>& cluster, int threads)
{
    std::vector<int> degree(cluster.size(), 0);
    CrustPolygons result = relist(polygons, threads,
                                  [&](std::size_t p, std::vector<int>& corners)
                                  {
                                      for_each_side(polygons, p,
                                                    [&](int a, int b)
                                                    {
                                                        if (cluster[a] != cluster[b])
                                                            corners.push_back(cluster[a]);
                                                    });
                                  });
    for (const int v : result.corners)
        ++degree[v];
    if (std::find(degree.begin(), degree.end(), 2) == degree.end())
        return result;
    // A vertex with two polygons lies on an edge between them and would make two triangles of the same corners.
    return relist(result, threads,
                  [&](std::size_t p, std::vector<int>& corners)
                  {
                      for (int k = result.first[p]; k < result.first[p + 1]; ++k)
                          if (degree[result.corners[k]] != 2)
                              corners.push_back(result.corners[k]);
                  });
}

/// Whether the mesh has lost a body: all of its corners lay in two clusters, or in clusters one after the other.
bool has_lost_a_body(const CrustPolygons& polygons, const WeldedCrust& welded)
{
    // Closed surfaces: each edge has two corners of polygons, each triangle three halves of an edge.
    const auto vertices = std::ptrdiff_t(polygons.vertices.size()), faces = std::ptrdiff_t(polygons.first.size()) - 1,
               corners = std::ptrdiff_t(polygons.corners.size());
    const std::vector<int>& degree = welded.half_edges.degree;
    const auto unused = std::count(degree.begin(), degree.end(), 0);
    return 2 * (vertices + faces) - corners != 2 * (vertices - unused) - std::ptrdiff_t(welded.mesh.triangles.size());
}

/// Marks the clusters of bodies of which no triangle is left.
void mark_lost_bodies(const CrustPolygons& polygons, const WeldedCrust& welded, const std::vector<int>& cluster,
                      std::vector<char>& is_marked)
{
    DisjointSets bodies(cluster.size());
    for (std::size_t p = 0; p + 1 < polygons.first.size(); ++p)
        for_each_side(polygons, p, [&](int a, int b) { bodies.join(a, b); });
    std::vector<char> is_left(cluster.size(), 0);
    for (const auto& t : welded.mesh.triangles)
        is_left[bodies.find(t[0])] = 1;
    for (int i = 0; i < int(cluster.size()); ++i)
        if (!is_left[bodies.find(i)])
            is_marked[cluster[i]] = 1;
}

} // namespace

WeldedCrust weld_clusters(const CrustPolygons& polygons, const std::vector<double>& scale,
                          const NearestSamples* nearest, int threads)
{
    std::vector<int> cluster = find_clusters(polygons, scale, nearest, threads);
    const std::vector<int> characteristic = count_euler_characteristics(polygons, cluster, threads);
    std::vector<char> is_bad(cluster.size());
    parallel_for(
        cluster.size(), threads, {}, [&](std::size_t i) { is_bad[i] = cluster[i] == int(i) && characteristic[i] != 1; },
        grain);
    dissolve(is_bad, cluster);
    constexpr int rounds = 4;
    WeldedCrust result;
    std::vector<int> corner;
    for (int round = 1;; ++round)
    {
        CrustPolygons contracted = contract(polygons, cluster, threads);
        corner = place(cluster, nearest);
        contracted.vertices = points_at(corner, polygons.vertices);
        result.mesh = triangulate_polygons(contracted, threads);
        result.half_edges = pair_half_edges(result.mesh, threads);
        const bool is_whole = result.half_edges.faulty.empty() && !has_lost_a_body(polygons, result);
        if (is_whole || round > rounds)
            break;
        // After the last round, as good as never: the crust as it is.
        std::fill(is_bad.begin(), is_bad.end(), char(round == rounds));
        for (const int t : result.half_edges.faulty)
            for (const int v : result.mesh.triangles[t])
                is_bad[v] = 1;
        if (result.half_edges.faulty.empty())
            mark_lost_bodies(polygons, result, cluster, is_bad);
        dissolve(is_bad, cluster);
    }

    // Only the lowest corner of each cluster is left.
    std::vector<int> number(cluster.size(), -1), merged(cluster.size(), 0);
    for (const int c : cluster)
        ++merged[c];
    for (std::size_t i = 0; i < cluster.size(); ++i)
        if (result.half_edges.degree[i] > 0)
        {
            const std::size_t n = result.scale.size();
            number[i] = int(n);
            result.mesh.vertices[n] = result.mesh.vertices[i];
            result.half_edges.outgoing[n] = result.half_edges.outgoing[i];
            result.half_edges.degree[n] = result.half_edges.degree[i];
            result.scale.push_back(scale[corner[i]]);
            result.corner.push_back(corner[i]);
            result.merged.push_back(merged[i]);
        }
    result.half_edges.outgoing.resize(result.scale.size());
    result.half_edges.degree.resize(result.scale.size());
    result.mesh.vertices.resize(result.scale.size());
    for (auto& t : result.mesh.triangles)
        t = {number[t[0]], number[t[1]], number[t[2]]};
    return result;
}

} // namespace recon
