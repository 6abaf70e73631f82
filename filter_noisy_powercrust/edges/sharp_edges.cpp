#include "sharp_edges.h"

#include "wedge.h"

#include <recon/median.h>
#include <recon/mesh/flip_edges.h>
#include <recon/mesh/half_edge_mesh.h>
#include <recon/mesh/triangle_cuts.h>
#include <recon/parallel.h>
#include <recon/search/keep_apart.h>
#include <recon/search/nearest_samples.h>
#include <recon/search/spatial_order.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

namespace recon
{
namespace
{

using Wedges = std::vector<std::optional<JudgedWedge>>;

// Lengths in reaches (RoundedSurface).
constexpr double landmark_spacing = 0.6, scout_spacing = 1.2, turn_within = 0.75, turn_cosine = 0.9;
/// Gains from which on a wedge votes for an edge, and from which on it is used where the votes win.
constexpr double voting_gain = 0.9, voting_wide_gain = 1.5, used_gain = 0.2;
constexpr double votes_within = 3, least_votes = 0.45, least_scout_votes = 0.2; // of the landmarks there
constexpr double blended_within = 1, farthest_move = 0.75;
/// Moves that neighbours forbid succeed when these have moved and edges have flipped.
constexpr int moving_rounds = 4;
constexpr int most_rings = 16; // that stay where vertices were, around what cuts

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
        return landmarks.empty() ? 0 : move_without_cuts(find_places(turns, landmarks, wedges));
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

    /// Of a few landmarks first, then of those around which enough of these vote: on round shapes that is none.
    Wedges fit_wedges(const std::vector<int>& landmarks, const Progress& progress) const
    {
        const Points places = points_at(landmarks, surface_.vertices);
        std::vector<double> radii;
        for (const int v : landmarks)
            radii.push_back(scout_spacing * surface_.reach[v]);
        const std::vector<int> scouts = keep_apart(places, radii);
        Wedges result(landmarks.size());
        const auto fit = [&](const std::vector<int>& chosen, const Progress& part)
        {
            constexpr std::size_t grain = 32;
            parallel_chunks(chosen.size(), threads_, grain, part,
                            [&](std::size_t begin, std::size_t end)
                            {
                                WedgeFitter fitter(surface_);
                                for (std::size_t i = begin; i < end; ++i)
                                    result[chosen[i]] = fitter.fit(landmarks[chosen[i]]);
                            });
        };
        fit(scouts, progress.part(0, 0.4));
        std::vector<char> is_promising = find_elected(landmarks, scouts, result, least_scout_votes);
        for (const int scout : scouts)
            is_promising[scout] = 0; // its wedge is there
        std::vector<int> others;
        for (std::size_t i = 0; i < landmarks.size(); ++i)
            if (is_promising[i])
                others.push_back(int(i));
        fit(others, progress.part(0.4, 1));
        return result;
    }

    /// Per landmark, whether more than that share of the voters around it vote for an edge. \param voters some
    /// landmarks.
    std::vector<char> find_elected(const std::vector<int>& landmarks, const std::vector<int>& voters,
                                   const Wedges& wedges, double share) const
    {
        const Points places = points_at(landmarks, surface_.vertices);
        const BlockSearch search(points_at(voters, places));
        std::vector<char> result(landmarks.size(), 0);
        parallel_for(landmarks.size(), threads_, {},
                     [&](std::size_t i)
                     {
                         std::vector<int> around;
                         search.within(places[i], votes_within * surface_.reach[landmarks[i]], around);
                         const auto agreeing = std::count_if(around.begin(), around.end(),
                                                             [&](int k) { return votes(wedges[voters[k]]); });
                         result[i] = double(agreeing) > share * double(around.size());
                     });
        return result;
    }

    /// Drops landmarks whose wedge gains too little, and those around which too few vote for an edge: a few bends of
    /// round shapes look sharp by chance.
    void take_vote(std::vector<int>& landmarks, Wedges& wedges) const
    {
        std::vector<int> all(landmarks.size());
        std::iota(all.begin(), all.end(), 0);
        const std::vector<char> is_elected = find_elected(landmarks, all, wedges, least_votes);
        std::size_t kept = 0;
        for (std::size_t i = 0; i < landmarks.size(); ++i)
            if (is_elected[i] && wedges[i] && wedges[i]->gain > used_gain)
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

    /// Where triangles cut others afterwards, vertices stay, in wider rings each time.
    /// \param places per vertex of the surface.
    int move_without_cuts(const Points& places)
    {
        Points wanted = mesh_.vertices;
        for (std::size_t v = 0; v < places.size(); ++v)
            wanted[vertex_[v]] = places[v];
        for (int rings = 0; rings <= most_rings; rings = std::max(1, 2 * rings))
        {
            TriangleMesh edited = mesh_;
            const int moved = move(edited, wanted);
            std::vector<char> stays = find_cut(edited);
            if (std::count(stays.begin(), stays.end(), 1) == 0)
            {
                mesh_ = std::move(edited);
                return moved;
            }
            for (int ring = 0; ring < rings; ++ring)
                widen(stays);
            for (std::size_t v = 0; v < stays.size(); ++v)
                if (stays[v])
                    wanted[v] = mesh_.vertices[v];
        }
        return 0;
    }

    /// Moves vertices as near to their places as neighbours allow, and flips edges around them. \returns how many
    /// moved.
    int move(TriangleMesh& edited, const Points& wanted) const
    {
        std::vector<int> waiting;
        for (const int v : vertex_)
            if (wanted[v] != edited.vertices[v])
                waiting.push_back(v);
        HalfEdgeMesh mesh(edited, pair_half_edges(edited, threads_));
        EdgeFlipOptions flips;
        flips.threads = threads_;
        std::vector<char> has_moved(wanted.size(), 0);
        for (int round = 0; round < moving_rounds && !waiting.empty(); ++round)
        {
            std::vector<char> changed(wanted.size(), 0);
            std::vector<int> left;
            for (const int v : waiting)
            {
                const bool arrived = mesh.move(v, wanted[v]);
                if (!arrived)
                    left.push_back(v);
                changed[v] = arrived || mesh.move(v, (wanted[v] + mesh.position(v)) / 2);
                has_moved[v] = has_moved[v] || changed[v];
            }
            flip_edges(mesh, flips, &changed);
            waiting = std::move(left);
        }
        return int(std::count(has_moved.begin(), has_moved.end(), 1));
    }

    /// Per vertex, whether a triangle there is not as it was and cuts another.
    std::vector<char> find_cut(const TriangleMesh& edited) const
    {
        std::vector<char> may_cut(mesh_.vertices.size(), 0), result = may_cut;
        const auto is_new = [&](int t)
        {
            const auto& corners = edited.triangles[t];
            return corners != mesh_.triangles[t] ||
                   std::any_of(corners.begin(), corners.end(),
                               [&](int v) { return edited.vertices[v] != mesh_.vertices[v]; });
        };
        for (std::size_t t = 0; t < edited.triangles.size(); ++t)
            if (is_new(int(t)))
                for (const int v : edited.triangles[t])
                    may_cut[v] = 1;
        const TriangleCuts cuts(edited, may_cut, threads_);
        const std::vector<int> found = cuts.count(edited.vertices);
        for (std::size_t i = 0; i < found.size(); ++i)
            if (const int t = cuts.moving()[i]; found[i] > 0 && is_new(t))
                for (const int v : edited.triangles[t])
                    result[v] = 1;
        return result;
    }

    /// Marks the vertices beside those that are marked, too.
    void widen(std::vector<char>& marked) const
    {
        const std::vector<char> before = marked;
        for (const auto& t : mesh_.triangles)
            if (before[t[0]] || before[t[1]] || before[t[2]])
                for (const int v : t)
                    marked[v] = 1;
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
