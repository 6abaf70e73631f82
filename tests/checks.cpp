#include "checks.h"

#include <recon/search/neighbours.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <sstream>

namespace checks
{
namespace
{

int find_root(std::vector<int>& parent, int i)
{
    while (parent[i] != i)
        i = parent[i] = parent[parent[i]];
    return i;
}

/// Closed, manifold and oriented along its edges. \returns the number of edges.
int examine_edges(const recon::TriangleMesh& mesh, MeshReport& report)
{
    struct Edge
    {
        int a, b, direction;
        bool operator<(const Edge& other) const { return a != other.a ? a < other.a : b < other.b; }
    };
    std::vector<Edge> edges;
    for (const auto& corners : mesh.triangles)
        for (int e = 0; e < 3; ++e)
        {
            const int from = corners[e], to = corners[(e + 1) % 3];
            edges.push_back({std::min(from, to), std::max(from, to), from < to ? 1 : -1});
        }
    std::sort(edges.begin(), edges.end());

    report.closed = report.edge_manifold = report.consistently_oriented = true;
    int edge_count = 0;
    for (std::size_t begin = 0; begin < edges.size();)
    {
        std::size_t end = begin;
        int direction = 0;
        while (end < edges.size() && edges[end].a == edges[begin].a && edges[end].b == edges[begin].b)
            direction += edges[end++].direction;
        ++edge_count;
        report.closed &= end - begin == 2;
        report.edge_manifold &= end - begin <= 2;
        report.consistently_oriented &= end - begin != 2 || direction == 0;
        begin = end;
    }
    return edge_count;
}

/// Whether the triangles at a vertex are connected through edges at it.
bool is_one_fan(const recon::TriangleMesh& mesh, int vertex, const std::vector<int>& triangles)
{
    std::map<int, std::vector<int>> by_neighbour;
    for (int i = 0; i < int(triangles.size()); ++i)
        for (const int w : mesh.triangles[triangles[i]])
            if (w != vertex)
                by_neighbour[w].push_back(i);
    std::vector<int> fan(triangles.size());
    std::iota(fan.begin(), fan.end(), 0);
    for (const auto& entry : by_neighbour)
        for (const int i : entry.second)
            fan[find_root(fan, i)] = find_root(fan, entry.second.front());
    for (int i = 1; i < int(triangles.size()); ++i)
        if (find_root(fan, i) != find_root(fan, 0))
            return false;
    return true;
}

double measure_volume(const recon::TriangleMesh& mesh)
{
    long double volume = 0;
    for (const auto& t : mesh.triangles)
    {
        const auto& o = mesh.vertices[mesh.triangles.front()[0]];
        const Eigen::Vector3d a = mesh.vertices[t[0]] - o, b = mesh.vertices[t[1]] - o, c = mesh.vertices[t[2]] - o;
        volume += a.x() * (b.y() * c.z() - b.z() * c.y()) - a.y() * (b.x() * c.z() - b.z() * c.x()) +
                  a.z() * (b.x() * c.y() - b.y() * c.x());
    }
    return double(volume / 6);
}

} // namespace

MeshReport examine_mesh(const recon::TriangleMesh& mesh)
{
    MeshReport report;
    report.finite =
        std::all_of(mesh.vertices.begin(), mesh.vertices.end(), [](const auto& v) { return v.allFinite(); });
    const int vertex_count = int(mesh.vertices.size());
    std::vector<int> parent(vertex_count);
    std::iota(parent.begin(), parent.end(), 0);
    std::vector<std::vector<int>> triangles_at(vertex_count);
    for (int t = 0; t < int(mesh.triangles.size()); ++t)
    {
        const auto& corners = mesh.triangles[t];
        if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0])
            ++report.degenerate_triangles;
        for (int e = 0; e < 3; ++e)
        {
            parent[find_root(parent, corners[e])] = find_root(parent, corners[(e + 1) % 3]);
            triangles_at[corners[e]].push_back(t);
        }
    }

    report.vertex_manifold = true;
    int used = 0;
    for (int v = 0; v < vertex_count; ++v)
    {
        if (triangles_at[v].empty())
        {
            ++report.unreferenced_vertices;
            continue;
        }
        ++used;
        report.vertex_manifold &= is_one_fan(mesh, v, triangles_at[v]);
        report.components += find_root(parent, v) == v;
    }
    report.euler_characteristic = used - examine_edges(mesh, report) + int(mesh.triangles.size());
    report.volume = measure_volume(mesh);
    return report;
}

std::string MeshReport::text() const
{
    std::ostringstream out;
    out << "components " << components << ", Euler characteristic " << euler_characteristic
        << (closed ? ", closed" : ", OPEN") << (edge_manifold ? "" : ", edges NOT MANIFOLD")
        << (vertex_manifold ? "" : ", vertices NOT MANIFOLD") << (consistently_oriented ? "" : ", NOT ORIENTED")
        << (finite ? "" : ", NOT FINITE") << ", degenerate " << degenerate_triangles << ", volume " << volume;
    return out.str();
}

SceneReport examine_ball_on_a_ground(const recon::TriangleMesh& mesh)
{
    constexpr double pi = 3.14159265358979323846, radius = 12, side = 100;
    const recon::Point middle(10, 5, radius);
    SceneReport report;
    for (const auto& t : mesh.triangles)
    {
        const recon::Point &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        const recon::Vector area = 0.5 * (b - a).cross(c - a);
        const recon::Point centre = (a + b + c) / 3;
        if (std::abs(centre.z()) < 0.5)
            report.ground += std::max(0.0, area.z()) / (side * side);
        else if (std::abs((centre - middle).norm() - radius) < 0.5)
            report.ball += std::max(0.0, area.dot((centre - middle).normalized())) / (4 * pi * radius * radius);
    }
    return report;
}

double share_facing(const recon::Vectors& normals, const recon::Vectors& truth, double above)
{
    int facing = 0;
    for (std::size_t i = 0; i < truth.size(); ++i)
        facing += normals[i].dot(truth[i]) > above;
    return double(facing) / double(truth.size());
}

double mean_angle(const recon::Vectors& normals, const recon::Vectors& truth)
{
    double sum = 0;
    for (std::size_t i = 0; i < truth.size(); ++i)
        sum += std::acos(std::clamp(normals[i].dot(truth[i]), -1.0, 1.0)) * 180 / M_PI;
    return sum / double(truth.size());
}

double share_faced(const recon::TriangleMesh& mesh, const recon::OrientedSamples& samples, double reach)
{
    recon::Vectors facing(mesh.vertices.size(), recon::Vector::Zero());
    for (const auto& t : mesh.triangles)
    {
        const recon::Point& a = mesh.vertices[t[0]];
        const recon::Vector area = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
        for (const int v : t)
            facing[v] += area;
    }
    const recon::NeighbourSearch search(mesh.vertices);
    int faced = 0;
    for (std::size_t i = 0; i < samples.points.size(); ++i)
    {
        const int v = search.nearest(samples.points[i]);
        faced += (mesh.vertices[v] - samples.points[i]).norm() < reach && facing[v].dot(samples.normals[i]) > 0;
    }
    return double(faced) / double(samples.points.size());
}

double share_faced_one_way(const recon::TriangleMesh& mesh, recon::OrientedSamples samples, double reach)
{
    const double faced = share_faced(mesh, samples, reach);
    for (recon::Vector& normal : samples.normals)
        normal = -normal;
    return std::max(faced, share_faced(mesh, samples, reach));
}

bool says(const std::vector<std::string>& warnings, const std::string& words)
{
    return std::any_of(warnings.begin(), warnings.end(),
                       [&](const std::string& text) { return text.find(words) != std::string::npos; });
}

} // namespace checks
