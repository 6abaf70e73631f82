#pragma once

#include <recon/geometry.h>
#include <recon/mesh/half_edges.h>

#include <array>
#include <vector>

namespace recon
{

/// A closed oriented manifold that is edited in place and stays one, of the same topology. Half-edges as in HalfEdges.
class HalfEdgeMesh
{
public:
    /// Forgets faux edges. \param mesh outlives this object. \param half_edges of it, none faulty.
    HalfEdgeMesh(TriangleMesh& mesh, HalfEdges half_edges);

    int triangles() const { return int(mesh_.triangles.size()); }
    int vertices() const { return int(mesh_.vertices.size()); }
    int origin(int h) const { return mesh_.triangles[h >> 2][h & 3]; }
    int target(int h) const { return origin(next_half_edge(h)); }
    int opposite(int h) const { return origin(previous_half_edge(h)); } ///< Third corner of its triangle.
    int twin(int h) const { return half_edges_.twin[h >> 2][h & 3]; }
    int degree(int v) const { return half_edges_.degree[v]; }
    const Point& position(int v) const { return mesh_.vertices[v]; }

    /// Calls call(half-edge) for all that lead from v.
    template <class Function>
    void for_each_from(int v, Function&& call) const
    {
        int h = half_edges_.outgoing[v];
        do
        {
            call(h);
            h = twin(previous_half_edge(h));
        } while (h != half_edges_.outgoing[v]);
    }

    /// Twice the area times the unit normal.
    Vector area_vector(int t) const;
    bool are_neighbours(int a, int b) const;

    /// Moves a vertex, unless a triangle would turn over. \returns whether it moved.
    bool move(int v, const Point& to);
    /// Whether the edge of h may become the other diagonal of its two triangles: no edge is there yet, and no corner is
    /// left with two triangles.
    bool can_flip(int h) const;
    void flip(int h);
    /// Makes three triangles of one, with a new vertex that lies above the inside of it, not far from its plane.
    /// \returns whether p lies so; else nothing changes.
    bool split(int t, const Point& p);
    /// Makes four triangles of the two beside the edge of h, with a new vertex on the edge or near it.
    /// \returns whether no triangle turns over; else nothing changes.
    bool split_edge(int h, const Point& p);

private:
    /// Room for a vertex at p and two triangles more. \returns the vertex.
    int append_vertex(const Point& p, int degree);
    void put(int t, int a, int b, int c);
    void join(int h, int g);

    TriangleMesh& mesh_;
    HalfEdges half_edges_;
};

/// Whether a triangle of that area vector faces where the surface around it does.
inline bool faces(const Vector& area_vector, const Vector& unit_mean)
{
    return area_vector.dot(unit_mean) > 0.2 * area_vector.norm();
}

/// Whether a triangle may get the area vector `after`: it turns neither against the mean of the surface around it, nor
/// much against what it was.
inline bool keeps_direction(const Vector& before, const Vector& after, const Vector& unit_mean)
{
    return faces(after, unit_mean) || after.dot(before) > 0.7 * after.norm() * before.norm();
}

} // namespace recon
