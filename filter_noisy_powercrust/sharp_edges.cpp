#include "sharp_edges.h"

#include "keep_apart.h"
#include "wedge.h"

#include <recon/flip_edges.h>
#include <recon/half_edge_mesh.h>
#include <recon/median.h>
#include <recon/nearest_samples.h>
#include <recon/parallel.h>
#include <recon/spatial_order.h>
#include <recon/triangle_cuts.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace recon
{
namespace
{

using Wedges = std::vector<std::optional<JudgedWedge>>;

// Lengths in reaches (RoundedSurface).
constexpr double landmark_spacing = 0.6, turn_within = 0.75, turn_cosine = 0.9;
/// Gains from which on a wedge votes for an edge, and from which on it is used where the votes win.
constexpr double voting_gain = 0.9, voting_wide_gain = 1.5, used_gain = 0.2;
constexpr double votes_within = 3, least_votes = 0.45; // of the landmarks there
constexpr double blended_within = 1, farthest_move = 0.75;
/// Moves that neighbours forbid succeed when these have moved and edges have flipped.
constexpr int moving_rounds = 4;

/// Twice the edges around each vertex, by the median of the neighbours' means.
std::vector<double> measure_reach(const TriangleMesh& mesh)
{
    const std::size_t n = mesh.vertices.size();
    std::vector<double> mean(n, 0), result(n, 0);
    std::vector<std::vector<int>> neighbours(n);
    for (const auto& t : mesh.triangles)
        for (int k = 0; k < 3; ++k)
        {
            const int a = t[k], b = t[(k + 1) % 3];
            mean[a] += (mesh.vertices[b] - mesh.vertices[a]).norm();
            neighbours[a].push_back(b);
        }
    for (std::size_t v = 0; v < n; ++v)
        mean[v] /= std::max(1.0, double(neighbours[v].size()));
    std::vector<double> around;
    for (std::size_t v = 0; v < n; ++v)
        if (!neighbours[v].empty())
        {
            around.clear();
            for (const int w : neighbours[v])
                around.push_back(mean[w]);
            result[v] = 2 * median(around);
        }
    return result;
}

Vectors list_vertex_normals(const TriangleMesh& mesh)
{
    Vectors result(mesh.vertices.size(), Vector::Zero());
    for (const auto& t : mesh.triangles)
    {
        const Point& p = mesh.vertices[t[0]];
        const Vector area = (mesh.vertices[t[1]] - p).cross(mesh.vertices[t[2]] - p);
        for (const int v : t)
            result[v] += area;
    }
    for (Vector& normal : result)
        normal.normalize();
    return result;
}

bool votes(const std::optional<JudgedWedge>& wedge)
{
    return wedge && wedge->gain > used_gain && (wedge->gain > voting_gain || wedge->wide_gain > voting_wide_gain);
}

class EdgeRestorer
{
public:
    EdgeRestorer(TriangleMesh& mesh, const Points& points, int threads)
        : mesh_(mesh), surface_(points), threads_(threads)
    {
        const Vectors normals = list_vertex_normals(mesh);
        const std::vector<double> reach = measure_reach(mesh);
        vertex_ = order_spatially(mesh.vertices).order;
        surface_.vertices = points_at(vertex_, mesh.vertices);
        for (const int v : vertex_)
        {
            surface_.normals.push_back(normals[v]);
            surface_.reach.push_back(reach[v]);
        }
        surface_.vertex_search = BlockSearch(surface_.vertices);
    }

    int run(const Progress& progress)
    {
        const std::vector<char> turns = find_turning();
        std::vector<int> landmarks = choose_landmarks(turns);
        if (landmarks.empty() || surface_.points.empty())
            return 0;
        place_points();
        Wedges wedges = fit_wedges(landmarks, progress);
        take_vote(landmarks, wedges);
        return landmarks.empty() ? 0 : move_to(find_places(turns, landmarks, wedges));
    }

private:
    /// Per vertex, whether normals around differ as they do beside an edge.
    std::vector<char> find_turning() const
    {
        std::vector<char> result(surface_.vertices.size(), 0);
        parallel_chunks(
            result.size(), threads_, 256, {},
            [&](std::size_t begin, std::size_t end)
            {
                std::vector<int> around;
                for (std::size_t v = begin; v < end; ++v)
                {
                    surface_.vertex_search.within(surface_.vertices[v], turn_within * surface_.reach[v], around);
                    result[v] =
                        std::any_of(around.begin(), around.end(),
                                    [&](int w) { return surface_.normals[w].dot(surface_.normals[v]) < turn_cosine; });
                }
            });
        return result;
    }

    std::vector<int> choose_landmarks(const std::vector<char>& turns) const
    {
        std::vector<int> turning;
        std::vector<double> radii;
        for (std::size_t v = 0; v < turns.size(); ++v)
            if (turns[v])
            {
                turning.push_back(int(v));
                radii.push_back(landmark_spacing * surface_.reach[v]);
            }
        std::vector<int> result = keep_apart(points_at(turning, surface_.vertices), radii);
        for (int& landmark : result)
            landmark = turning[landmark];
        return result;
    }

    void place_points()
    {
        const Points& points = surface_.points;
        surface_.point_search = BlockSearch(points);
        surface_.nearest = find_nearest_samples(points, surface_.vertices, threads_).sample;
        surface_.height.resize(points.size());
        parallel_for(points.size(), threads_, {},
                     [&](std::size_t i)
                     {
                         const int v = surface_.nearest[i];
                         surface_.height[i] = std::abs((points[i] - surface_.vertices[v]).dot(surface_.normals[v]));
                     });
    }

    Wedges fit_wedges(const std::vector<int>& landmarks, const Progress& progress) const
    {
        constexpr std::size_t grain = 32;
        Wedges result(landmarks.size());
        parallel_chunks(landmarks.size(), threads_, grain, progress,
                        [&](std::size_t begin, std::size_t end)
                        {
                            WedgeFitter fitter(surface_);
                            for (std::size_t i = begin; i < end; ++i)
                                result[i] = fitter.fit(landmarks[i]);
                        });
        return result;
    }

    /// Drops landmarks whose wedge gains too little, and those around which too few vote for an edge: a few bends of
    /// round shapes look sharp by chance.
    void take_vote(std::vector<int>& landmarks, Wedges& wedges) const
    {
        const BlockSearch search(points_at(landmarks, surface_.vertices));
        std::vector<char> stays(landmarks.size(), 0);
        parallel_for(landmarks.size(), threads_, {},
                     [&](std::size_t i)
                     {
                         if (!wedges[i] || wedges[i]->gain <= used_gain)
                             return;
                         const int v = landmarks[i];
                         std::vector<int> around;
                         search.within(surface_.vertices[v], votes_within * surface_.reach[v], around);
                         const auto agreeing =
                             std::count_if(around.begin(), around.end(), [&](int k) { return votes(wedges[k]); });
                         stays[i] = double(agreeing) > least_votes * double(around.size());
                     });
        std::size_t kept = 0;
        for (std::size_t i = 0; i < landmarks.size(); ++i)
            if (stays[i])
            {
                landmarks[kept] = landmarks[i];
                wedges[kept++] = std::move(wedges[i]);
            }
        landmarks.resize(kept);
        wedges.resize(kept);
    }

    /// Per vertex: the mean of its places on the wedges around, nearer ones weighing more; where it is if there are
    /// none.
    Points find_places(const std::vector<char>& turns, const std::vector<int>& landmarks, const Wedges& wedges) const
    {
        Points result = surface_.vertices;
        const BlockSearch search(points_at(landmarks, surface_.vertices));
        parallel_for(result.size(), threads_, {},
                     [&](std::size_t v)
                     {
                         if (!turns[v])
                             return;
                         const Point from = result[v];
                         const double reach = surface_.reach[v], radius = blended_within * reach;
                         std::vector<int> around;
                         search.within(from, radius, around);
                         Point sum = Point::Zero();
                         double weights = 0;
                         for (const int k : around)
                         {
                             const int landmark = landmarks[k];
                             if (is_other_sheet(surface_.normals[landmark], surface_.normals[v]))
                                 continue;
                             const Point place = wedges[k]->wedge.project(from);
                             if (!((place - from).norm() < farthest_move * reach))
                                 continue;
                             const double near =
                                 1 - (surface_.vertices[landmark] - from).squaredNorm() / (radius * radius);
                             sum += near * near * place;
                             weights += near * near;
                         }
                         if (weights > 0)
                             result[v] = sum / weights;
                     });
        return result;
    }

    /// Takes back moves after which triangles cut others. Looked at once: what stays beside what moves, and flips, may
    /// still leave a few.
    void avoid_cuts(Points& places) const
    {
        std::vector<char> may_move(mesh_.vertices.size(), 0);
        Points moved = mesh_.vertices;
        for (std::size_t v = 0; v < places.size(); ++v)
        {
            may_move[vertex_[v]] = places[v] != surface_.vertices[v];
            moved[vertex_[v]] = places[v];
        }
        const TriangleCuts cuts(mesh_, may_move, threads_);
        const std::vector<int> found = cuts.count(moved);
        for (std::size_t i = 0; i < found.size(); ++i)
            if (found[i] > 0)
                for (const int v : mesh_.triangles[cuts.moving()[i]])
                    moved[v] = mesh_.vertices[v];
        for (std::size_t v = 0; v < places.size(); ++v)
            places[v] = moved[vertex_[v]];
    }

    int move_to(Points places)
    {
        avoid_cuts(places);
        std::vector<std::size_t> waiting;
        for (std::size_t v = 0; v < places.size(); ++v)
            if (places[v] != surface_.vertices[v])
                waiting.push_back(v);
        HalfEdgeMesh mesh(mesh_, pair_half_edges(mesh_, threads_));
        EdgeFlipOptions flips;
        flips.threads = threads_;
        std::vector<char> has_moved(mesh_.vertices.size(), 0);
        for (int round = 0; round < moving_rounds && !waiting.empty(); ++round)
        {
            std::vector<char> changed(mesh_.vertices.size(), 0);
            std::vector<std::size_t> left;
            for (const std::size_t i : waiting)
            {
                const int v = vertex_[i];
                const bool arrived = mesh.move(v, places[i]);
                if (!arrived)
                    left.push_back(i);
                changed[v] = arrived || mesh.move(v, (places[i] + mesh.position(v)) / 2);
                has_moved[v] = has_moved[v] || changed[v];
            }
            flip_edges(mesh, flips, &changed);
            waiting = std::move(left);
        }
        return int(std::count(has_moved.begin(), has_moved.end(), 1));
    }

    TriangleMesh& mesh_;
    RoundedSurface surface_;
    std::vector<int> vertex_; ///< Of the mesh, per vertex of the surface.
    int threads_;
};

} // namespace

int restore_sharp_edges(TriangleMesh& mesh, const Points& points, int threads, const Progress& progress)
{
    return EdgeRestorer(mesh, points, threads).run(progress);
}

} // namespace recon
