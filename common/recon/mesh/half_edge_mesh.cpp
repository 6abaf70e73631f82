#include <recon/mesh/half_edge_mesh.h>

#include <Eigen/Geometry>

#include <utility>

namespace recon
{

HalfEdgeMesh::HalfEdgeMesh(TriangleMesh& mesh, HalfEdges half_edges) : mesh_(mesh), half_edges_(std::move(half_edges))
{
    mesh_.faux_edges.clear();
}

Vector HalfEdgeMesh::area_vector(int t) const
{
    const auto& corners = mesh_.triangles[t];
    const Point& a = position(corners[0]);
    return (position(corners[1]) - a).cross(position(corners[2]) - a);
}

bool HalfEdgeMesh::are_neighbours(int a, int b) const
{
    bool found = false;
    for_each_from(a, [&](int h) { found = found || target(h) == b; });
    return found;
}

bool HalfEdgeMesh::move(int v, const Point& to)
{
    Vector mean = Vector::Zero();
    for_each_from(v, [&](int h) { mean += area_vector(h >> 2); });
    mean.normalize();
    bool keeps = true;
    for_each_from(v,
                  [&](int h)
                  {
                      const Vector after = (position(target(h)) - to).cross(position(opposite(h)) - to);
                      keeps = keeps && keeps_direction(area_vector(h >> 2), after, mean);
                  });
    if (keeps)
        mesh_.vertices[v] = to;
    return keeps;
}

bool HalfEdgeMesh::can_flip(int h) const
{
    return degree(origin(h)) > 3 && degree(target(h)) > 3 && !are_neighbours(opposite(h), opposite(twin(h)));
}

void HalfEdgeMesh::flip(int h)
{
    const int g = twin(h), t = h >> 2, u = g >> 2;
    const int a = origin(h), b = target(h), c = opposite(h), d = opposite(g);
    const int bc = twin(next_half_edge(h)), ca = twin(previous_half_edge(h)), ad = twin(next_half_edge(g)),
              db = twin(previous_half_edge(g));
    put(t, c, a, d);
    put(u, d, b, c);
    join(4 * t, ca);
    join(4 * t + 1, ad);
    join(4 * u, db);
    join(4 * u + 1, bc);
    join(4 * t + 2, 4 * u + 2);
    --half_edges_.degree[a];
    --half_edges_.degree[b];
    ++half_edges_.degree[c];
    ++half_edges_.degree[d];
}

bool HalfEdgeMesh::split(int t, const Point& p)
{
    const std::array<int, 3> corners = mesh_.triangles[t];
    const Vector normal = area_vector(t).normalized();
    std::array<int, 3> outside;
    for (int k = 0; k < 3; ++k)
    {
        const Point& a = position(corners[k]);
        if (!faces((position(corners[k == 2 ? 0 : k + 1]) - a).cross(p - a), normal))
            return false;
        outside[k] = twin(4 * t + k);
    }
    const int parts[3] = {t, triangles(), triangles() + 1}, v = append_vertex(p, 3);
    for (int k = 0; k < 3; ++k)
    {
        put(parts[k], corners[k], corners[k == 2 ? 0 : k + 1], v);
        join(4 * parts[k], outside[k]);
        join(4 * parts[k] + 1, 4 * parts[k == 2 ? 0 : k + 1] + 2);
        ++half_edges_.degree[corners[k]];
    }
    return true;
}

bool HalfEdgeMesh::split_edge(int h, const Point& p)
{
    const int g = twin(h), t = h >> 2, u = g >> 2;
    const int a = origin(h), b = target(h), c = opposite(h), d = opposite(g);
    const Vector mean = (area_vector(t) + area_vector(u)).normalized();
    const int sides[4][2] = {{b, c}, {c, a}, {a, d}, {d, b}};
    for (const auto& [from, to] : sides)
        if (!faces((position(from) - p).cross(position(to) - p), mean))
            return false;
    const int bc = twin(next_half_edge(h)), ca = twin(previous_half_edge(h)), ad = twin(next_half_edge(g)),
              db = twin(previous_half_edge(g));
    const int w = triangles(), x = w + 1, v = append_vertex(p, 4);
    put(t, b, c, v);
    put(w, c, a, v);
    put(u, a, d, v);
    put(x, d, b, v);
    join(4 * t, bc);
    join(4 * w, ca);
    join(4 * u, ad);
    join(4 * x, db);
    join(4 * t + 1, 4 * w + 2);
    join(4 * w + 1, 4 * u + 2);
    join(4 * u + 1, 4 * x + 2);
    join(4 * x + 1, 4 * t + 2);
    ++half_edges_.degree[c];
    ++half_edges_.degree[d];
    return true;
}

int HalfEdgeMesh::append_vertex(const Point& p, int degree)
{
    mesh_.vertices.push_back(p);
    mesh_.triangles.resize(mesh_.triangles.size() + 2);
    half_edges_.twin.resize(mesh_.triangles.size());
    half_edges_.outgoing.push_back(-1);
    half_edges_.degree.push_back(degree);
    return vertices() - 1;
}

void HalfEdgeMesh::put(int t, int a, int b, int c)
{
    mesh_.triangles[t] = {a, b, c};
    half_edges_.outgoing[a] = 4 * t;
    half_edges_.outgoing[b] = 4 * t + 1;
    half_edges_.outgoing[c] = 4 * t + 2;
}

void HalfEdgeMesh::join(int h, int g)
{
    half_edges_.twin[h >> 2][h & 3] = g;
    half_edges_.twin[g >> 2][g & 3] = h;
}

} // namespace recon
