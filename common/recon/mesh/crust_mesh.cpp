#include <recon/mesh/crust_mesh.h>

#include <recon/disjoint_sets.h>
#include <recon/errors.h>
#include <recon/parallel.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace recon
{
namespace
{

/// Smallest height of a triangle over its longest edge: 0 if it is degenerate.
double triangle_quality(const Point& a, const Point& b, const Point& c)
{
    const double longest2 = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    return longest2 > 0 ? (b - a).cross(c - a).norm() / longest2 : 0;
}

/// Corner of a polygon from which a fan has the best worst triangle.
int best_fan_corner(const Points& vertices, const std::vector<int>& polygon)
{
    const int n = int(polygon.size());
    int best = 0;
    double best_quality = -1;
    const int apexes = n == 3 ? 0 : n == 4 ? 2 : n; // opposite corners of a quadrangle have the same fan
    for (int apex = 0; apex < apexes; ++apex)
    {
        double worst = 1e300;
        for (int k = 1; k + 1 < n; ++k)
            worst = std::min(worst, triangle_quality(vertices[polygon[apex]], vertices[polygon[(apex + k) % n]],
                                                     vertices[polygon[(apex + k + 1) % n]]));
        if (worst > best_quality)
        {
            best_quality = worst;
            best = apex;
        }
    }
    return best;
}

/// Writes the polygon's triangles, two fewer than its corners, from position `at` on.
void write_fan(const Points& vertices, const std::vector<int>& polygon, std::size_t at, TriangleMesh& mesh)
{
    const int n = int(polygon.size()), apex = best_fan_corner(vertices, polygon);
    const auto corner = [&](int k) { return polygon[(apex + k) % n]; };
    for (int k = 1; k + 1 < n; ++k, ++at)
    {
        mesh.triangles[at] = {corner(0), corner(k), corner(k + 1)};
        mesh.faux_edges[at] = std::uint8_t((k > 1 ? 1 : 0) | (k + 2 < n ? 4 : 0));
    }
}

constexpr std::size_t grain = 8192;

std::size_t chunk_count(std::size_t items)
{
    return (items + grain - 1) / grain;
}

template <class Item>
void append(std::vector<Item>& whole, const std::vector<Item>& part)
{
    whole.insert(whole.end(), part.begin(), part.end());
}

/// Cells with both labels. In the order of a coarse Z-order curve: cells are numbered by their balls, and a ball can
/// touch both sides of a body, so that neighbours on the surface would lie far apart in memory.
std::vector<int> list_mixed_cells(const Triangulation& regular, const std::vector<Side>& labels, int threads)
{
    const std::vector<int> found = parallel_collect<int>(
        std::size_t(regular.finite_cells), threads, {},
        [&](std::size_t c, std::vector<int>& mixed)
        {
            const auto& v = regular.cells[c].vertices;
            const Side side = labels[v[0]];
            if (labels[v[1]] != side || labels[v[2]] != side || labels[v[3]] != side)
                mixed.push_back(int(c));
        },
        grain);
    constexpr int bits = 6, steps = 1 << bits;
    Eigen::AlignedBox3d box;
    for (const int c : found)
        box.extend(regular.centres[c]);
    const double step = found.empty() ? 1 : box.sizes().maxCoeff() / steps;
    const auto bucket = [&](const Point& p)
    {
        unsigned code = 0;
        for (int k = 0; k < 3; ++k)
        {
            const int along = step > 0 ? std::clamp(int((p[k] - box.min()[k]) / step), 0, steps - 1) : 0;
            for (int b = 0; b < bits; ++b)
                code |= unsigned((along >> b) & 1) << (3 * b + k);
        }
        return code;
    };
    std::vector<unsigned> code(found.size());
    parallel_for(
        found.size(), threads, {}, [&](std::size_t i) { code[i] = bucket(regular.centres[found[i]]); }, grain);
    std::vector<int> first((std::size_t(1) << (3 * bits)) + 1, 0), sorted(found.size());
    for (const unsigned c : code)
        ++first[c + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    for (std::size_t i = 0; i < found.size(); ++i)
        sorted[first[code[i]]++] = found[i];
    return sorted;
}

Extent measure_extent(const TriangleMesh& mesh)
{
    Extent result;
    for (const auto& t : mesh.triangles)
        result.add(mesh, t);
    return result;
}

} // namespace

CrustPolygons list_crust_polygons(const Triangulation& regular, const std::vector<Side>& labels, int threads)
{
    const std::vector<int> mixed = list_mixed_cells(regular, labels, threads);
    CrustPolygons result;
    result.vertices.reserve(mixed.size());
    result.ball.reserve(mixed.size());
    std::vector<int> vertex_of_cell(std::size_t(regular.finite_cells), -1);
    for (const int c : mixed)
    {
        vertex_of_cell[c] = int(result.vertices.size());
        result.vertices.push_back(regular.centres[c]);
        result.ball.push_back(regular.cells[c].vertices[0]);
    }

    struct Chunk
    {
        std::vector<int> size, corners;
    };
    std::vector<Chunk> chunks(chunk_count(mixed.size()));
    const auto list_chunk = [&](std::size_t begin, std::size_t end)
    {
        Chunk& chunk = chunks[begin / grain];
        std::vector<int> ring;
        for (std::size_t m = begin; m < end; ++m)
        {
            const int c = mixed[m];
            const auto& v = regular.cells[c].vertices;
            for (int i = 0; i < 4; ++i)
                for (int j = 0; j < 4; ++j)
                {
                    if (labels[v[i]] != Side::inner || labels[v[j]] != Side::outer || !regular.can_be_lowest(c, i, j))
                        continue;
                    if (!regular.list_ring_from_lowest(c, v[i], v[j], ring))
                        continue;
                    chunk.size.push_back(int(ring.size()));
                    for (const int k : ring)
                        chunk.corners.push_back(vertex_of_cell[k]);
                }
        }
    };
    parallel_chunks(mixed.size(), threads, grain, {}, list_chunk);
    std::size_t polygons = 0, corners = 0;
    for (const Chunk& chunk : chunks)
    {
        polygons += chunk.size.size();
        corners += chunk.corners.size();
    }
    result.first.reserve(polygons + 1);
    result.corners.reserve(corners);
    for (const Chunk& chunk : chunks)
    {
        for (const int size : chunk.size)
            result.first.push_back(result.first.back() + size);
        append(result.corners, chunk.corners);
    }
    return result;
}

TriangleMesh triangulate_polygons(const CrustPolygons& polygons, int threads)
{
    const std::size_t count = polygons.first.size() - 1;
    TriangleMesh mesh;
    mesh.vertices = polygons.vertices;
    mesh.triangles.resize(polygons.corners.size() - 2 * count);
    mesh.faux_edges.resize(mesh.triangles.size());
    parallel_chunks(count, threads, grain, {},
                    [&](std::size_t begin, std::size_t end)
                    {
                        std::vector<int> polygon;
                        for (std::size_t p = begin; p < end; ++p)
                        {
                            polygon.assign(polygons.corners.begin() + polygons.first[p],
                                           polygons.corners.begin() + polygons.first[p + 1]);
                            write_fan(polygons.vertices, polygon, std::size_t(polygons.first[p]) - 2 * p, mesh);
                        }
                    });
    return mesh;
}

void Extent::add(const TriangleMesh& mesh, const std::array<int, 3>& t)
{
    const Point &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    volume += a.dot(b.cross(c)) / 6;
    area += (b - a).cross(c - a).norm() / 2;
}

MeshComponents find_components(const TriangleMesh& mesh)
{
    DisjointSets sets(mesh.vertices.size());
    for (const auto& t : mesh.triangles)
    {
        sets.join(t[0], t[1]);
        sets.join(t[0], t[2]);
    }
    MeshComponents result;
    std::vector<int> number(mesh.vertices.size(), -1);
    for (const auto& t : mesh.triangles)
    {
        int& component = number[sets.find(t[0])];
        if (component < 0)
            component = result.count++;
        result.of_triangle.push_back(component);
    }
    result.of_vertex.resize(mesh.vertices.size());
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
        result.of_vertex[v] = number[std::size_t(sets.find(int(v)))];
    return result;
}

std::vector<int> keep_triangles(TriangleMesh& mesh, const std::vector<char>& keep)
{
    TriangleMesh kept;
    std::vector<int> number(mesh.vertices.size(), -1), former;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        if (!keep[i])
            continue;
        std::array<int, 3> triangle;
        for (int k = 0; k < 3; ++k)
        {
            int& v = number[mesh.triangles[i][k]];
            if (v < 0)
            {
                v = int(former.size());
                former.push_back(mesh.triangles[i][k]);
                kept.vertices.push_back(mesh.vertices[former.back()]);
            }
            triangle[k] = v;
        }
        kept.triangles.push_back(triangle);
        if (!mesh.faux_edges.empty())
            kept.faux_edges.push_back(mesh.faux_edges[i]);
    }
    mesh = std::move(kept);
    return former;
}

std::vector<std::vector<int>> list_rims(const TriangleMesh& mesh)
{
    std::vector<std::pair<int, int>> edges; // directed
    edges.reserve(3 * mesh.triangles.size());
    for (const auto& t : mesh.triangles)
        for (int e = 0; e < 3; ++e)
            edges.emplace_back(t[e], t[(e + 1) % 3]);
    std::sort(edges.begin(), edges.end());
    // At a manifold's boundary each vertex has one edge in and one out.
    std::vector<int> next(mesh.vertices.size(), -1);
    for (const auto& [from, to] : edges)
        if (!std::binary_search(edges.begin(), edges.end(), std::make_pair(to, from)))
            next[from] = to;
    std::vector<std::vector<int>> rims;
    for (int v = 0; v < int(next.size()); ++v)
    {
        if (next[v] < 0)
            continue;
        std::vector<int> rim;
        for (int w = v; w >= 0 && next[w] >= 0;)
        {
            rim.push_back(w);
            w = std::exchange(next[w], -1);
        }
        rims.push_back(std::move(rim));
    }
    return rims;
}

Topology measure_topology(const TriangleMesh& mesh)
{
    const std::vector<std::vector<int>> rims = list_rims(mesh);
    std::size_t boundary = 0;
    for (const std::vector<int>& rim : rims)
        boundary += rim.size();
    Topology result;
    result.boundary_loops = int(rims.size());
    result.components = find_components(mesh).count;
    const int edge_count = int((3 * mesh.triangles.size() + boundary) / 2);
    result.euler_characteristic = int(mesh.vertices.size()) - edge_count + int(mesh.triangles.size());
    return result;
}

Topology measure_closed_topology(const TriangleMesh& mesh)
{
    Topology result;
    result.components = find_components(mesh).count;
    // Three edges for two triangles.
    result.euler_characteristic = int(mesh.vertices.size()) - int(mesh.triangles.size()) / 2;
    return result;
}

double measure_volume(const TriangleMesh& mesh)
{
    return measure_extent(mesh).volume;
}

double measure_thickness(const TriangleMesh& mesh)
{
    const auto [volume, area] = measure_extent(mesh);
    return area > 0 ? 2 * volume / area : 0;
}

void check_encloses_volume(const TriangleMesh& mesh)
{
    constexpr double least_thickness = 1e-12;
    if (measure_thickness(mesh) <= least_thickness)
        throw AlgorithmFailure("The surface through the points encloses no volume: they are too few or too scattered "
                               "to tell an inside. Use a denser cloud.");
}

} // namespace recon
