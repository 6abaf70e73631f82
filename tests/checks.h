#pragma once

#include <recon/geometry.h>

#include <string>
#include <vector>

namespace checks
{

/// What an independent look at a triangle mesh finds; shares no code with the algorithms.
struct MeshReport
{
    bool closed = false;                ///< Every edge has exactly two triangles.
    bool edge_manifold = false;         ///< No edge has more than two triangles.
    bool vertex_manifold = false;       ///< The triangles around each vertex form one fan.
    bool consistently_oriented = false; ///< The two triangles of an edge run through it in opposite directions.
    bool finite = false;                ///< All vertices are finite.
    int components = 0;                 ///< By shared vertices; vertices without triangles do not count.
    int euler_characteristic = 0;       ///< V - E + F over all components.
    int unreferenced_vertices = 0;
    int degenerate_triangles = 0; ///< Two corners are one vertex.
    double volume = 0;            ///< Signed; positive = outward.

    bool is_closed_oriented_manifold() const
    {
        return closed && edge_manifold && vertex_manifold && consistently_oriented && finite &&
               degenerate_triangles == 0;
    }
    /// Genus summed over the components of a closed orientable surface.
    int genus() const { return components - euler_characteristic / 2; }
    std::string text() const;
};

MeshReport examine_mesh(const recon::TriangleMesh& mesh);

/// Of shapes::ball_on_a_ground(), as shares of the true areas: what of ball and ground the mesh has near its place,
/// facing away from the ball's centre and up [0..1 and a little more].
struct SceneReport
{
    double ball = 0, ground = 0;
};
SceneReport examine_ball_on_a_ground(const recon::TriangleMesh& mesh);

/// Share of normals whose cosine with the true ones is above this: within a right angle of them, unless said.
double share_facing(const recon::Vectors& normals, const recon::Vectors& truth, double above = 0);

/// Between normals and the true ones [degrees].
double mean_angle(const recon::Vectors& normals, const recon::Vectors& truth);

/// Share of samples that have a vertex of the mesh within `reach` and face as the mesh does at the nearest one.
double share_faced(const recon::TriangleMesh& mesh, const recon::OrientedSamples& samples, double reach);
/// The same of an open sheet, which may face either way as a whole.
double share_faced_one_way(const recon::TriangleMesh& mesh, recon::OrientedSamples samples, double reach);

/// Whether one of the texts has these words.
bool says(const std::vector<std::string>& warnings, const std::string& words);

} // namespace checks
