#include <recon/weld_clusters.h>

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

/// Per vertex the lowest vertex of its cluster.
std::vector<int> find_clusters(const CrustPolygons& polygons, const std::vector<double>& scale)
{
    DisjointSets sets(polygons.vertices.size());
    for (std::size_t p = 0; p + 1 < polygons.first.size(); ++p)
        for_each_side(polygons, p,
                      [&](int a, int b)
                      {
                          const double reach = cluster_length * std::min(scale[a], scale[b]);
                          if (a < b && (polygons.vertices[a] - polygons.vertices[b]).squaredNorm() <= reach * reach)
                              sets.join(a, b);
                      });
    std::vector<int> cluster(polygons.vertices.size());
    for (int i = 0; i < int(cluster.size()); ++i)
        cluster[i] = sets.find(i);
    return cluster;
}

/// Per cluster (at its lowest vertex) vertices - edges + faces.
std::vector<int> count_euler_characteristics(const CrustPolygons& polygons, const std::vector<int>& cluster)
{
    std::vector<int> twice(cluster.size(), 0);
    for (const int c : cluster)
        twice[c] += 2;
    for (std::size_t p = 0; p + 1 < polygons.first.size(); ++p)
    {
        const int own = cluster[polygons.corners[polygons.first[p]]];
        bool inside = true;
        for_each_side(polygons, p,
                      [&](int a, int b)
                      {
                          inside = inside && cluster[a] == own;
                          if (cluster[a] == cluster[b])
                              --twice[cluster[a]];
                      });
        if (inside)
            twice[own] += 2;
    }
    for (int& value : twice)
        value /= 2;
    return twice;
}

/// Makes singles of the vertices whose cluster is bad.
void dissolve(const std::vector<char>& is_bad, std::vector<int>& cluster)
{
    for (int i = int(cluster.size()) - 1; i >= 0; --i) // a cluster's lowest vertex last
        if (is_bad[cluster[i]])
            cluster[i] = i;
}

/// The polygons with one vertex per cluster, less those with fewer than three. Vertices keep their numbers.
CrustPolygons contract(const CrustPolygons& polygons, const std::vector<int>& cluster)
{
    CrustPolygons result;
    result.corners.reserve(polygons.corners.size());
    std::vector<int> degree(cluster.size(), 0);
    const auto close_polygon = [](CrustPolygons& list)
    {
        if (int(list.corners.size()) - list.first.back() < 3)
            list.corners.resize(std::size_t(list.first.back()));
        else
            list.first.push_back(int(list.corners.size()));
    };
    for (std::size_t p = 0; p + 1 < polygons.first.size(); ++p)
    {
        for_each_side(polygons, p,
                      [&](int a, int b)
                      {
                          if (cluster[a] != cluster[b])
                              result.corners.push_back(cluster[a]);
                      });
        close_polygon(result);
    }
    for (const int v : result.corners)
        ++degree[v];
    if (std::find(degree.begin(), degree.end(), 2) == degree.end())
        return result;
    // A vertex with two polygons lies on an edge between them and would make two triangles of the same corners.
    CrustPolygons straight;
    straight.corners.reserve(result.corners.size());
    for (std::size_t p = 0; p + 1 < result.first.size(); ++p)
    {
        for (int k = result.first[p]; k < result.first[p + 1]; ++k)
            if (degree[result.corners[k]] != 2)
                straight.corners.push_back(result.corners[k]);
        close_polygon(straight);
    }
    return straight;
}

} // namespace

WeldedCrust weld_clusters(const CrustPolygons& polygons, const std::vector<double>& scale, int threads)
{
    std::vector<int> cluster = find_clusters(polygons, scale);
    const std::vector<int> characteristic = count_euler_characteristics(polygons, cluster);
    std::vector<char> is_bad(cluster.size());
    for (std::size_t i = 0; i < cluster.size(); ++i)
        is_bad[i] = cluster[i] == int(i) && characteristic[i] != 1;
    dissolve(is_bad, cluster);
    constexpr int rounds = 4;
    WeldedCrust result;
    for (int round = 1;; ++round)
    {
        CrustPolygons contracted = contract(polygons, cluster);
        contracted.vertices = polygons.vertices;
        result.mesh = triangulate_polygons(contracted, threads);
        result.half_edges = pair_half_edges(result.mesh, threads);
        if (result.half_edges.faulty.empty() || round > rounds)
            break;
        // After the last round, as good as never: the crust as it is.
        std::fill(is_bad.begin(), is_bad.end(), char(round == rounds));
        for (const int t : result.half_edges.faulty)
            for (const int v : result.mesh.triangles[t])
                is_bad[v] = 1;
        dissolve(is_bad, cluster);
    }

    // Only the lowest vertex of each cluster is left.
    std::vector<int> number(cluster.size(), -1), merged(cluster.size(), 0);
    for (const int c : cluster)
        ++merged[c];
    for (std::size_t i = 0; i < cluster.size(); ++i)
        if (result.half_edges.degree[i] > 0)
        {
            const std::size_t n = result.scale.size();
            number[i] = int(n);
            result.mesh.vertices[n] = polygons.vertices[i];
            result.half_edges.outgoing[n] = result.half_edges.outgoing[i];
            result.half_edges.degree[n] = result.half_edges.degree[i];
            result.scale.push_back(scale[i]);
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
