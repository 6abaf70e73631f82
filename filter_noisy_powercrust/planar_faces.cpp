#include "planar_faces.h"

#include <recon/delaunay.h>
#include <recon/disjoint_sets.h>
#include <recon/geometry.h>
#include <recon/median.h>
#include <recon/signed_labelling.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>
#include <utility>

namespace recon
{
namespace
{

constexpr double pi = 3.14159265358979323846;
/// Share of contradictions above which the regions do not alternate.
constexpr double contradictory = 0.05;
/// A closed rim has as many points: noise makes smaller loops within one.
constexpr int fewest_in_loop = 6;
/// A point both of whose edges are longer than so many medians lies on no rim, where strays are expected.
constexpr double far_from_rim = 4;

/// Rounds in which single points are left out; then whole chains that do not close are.
constexpr int rounds_of_strays = 4;

/// What a rim costs: at each of its points 1 plus the cosine of the angle between its edges, 0 where it runs straight
/// on and 2 where it turns back; so much per end that is open; and so much per median edge of its length.
constexpr double open_end = 2, length_cost = 0.2;
constexpr int most_exchanges = 50; // rounds
constexpr double least_gain = 1e-6;

/// Planar Delaunay triangulation: what an apex beyond the plane sees, since a sphere through the apex and a triangle
/// meets the plane in the triangle's circumcircle.
class PlanarTriangulation
{
public:
    explicit PlanarTriangulation(const std::vector<Eigen::Vector2d>& points) : apex_(int(points.size()))
    {
        for (const Eigen::Vector2d& p : points)
            points_.emplace_back(p.x(), p.y(), 0);
        points_.emplace_back(0, 0, 1);
        cells_ = triangulate_delaunay(points_);
    }

    int triangles() const { return cells_.finite_cells; }
    /// What lies around the convex hull, as a neighbour.
    int outside() const { return cells_.finite_cells; }
    double length(int a, int b) const { return (points_[a] - points_[b]).norm(); }

    std::array<int, 3> triangle(int t) const
    {
        std::array<int, 3> result;
        int k = 0;
        for (const int v : cells_.cells[t].vertices)
            if (v != apex_)
                result[k++] = v;
        const Vector u = points_[result[1]] - points_[result[0]], v = points_[result[2]] - points_[result[0]];
        if (u.cross(v).z() < 0)
            std::swap(result[1], result[2]);
        return result;
    }

    /// Calls call(a, b, triangle, neighbour) with a < b for every edge once.
    template <class Call>
    void for_edges(Call&& call) const
    {
        for (int t = 0; t < triangles(); ++t)
        {
            const auto& cell = cells_.cells[t];
            for (int i = 0; i < 4; ++i)
            {
                const int neighbour = std::min(cell.neighbours[i], outside());
                if (cell.vertices[i] == apex_ || neighbour < t)
                    continue;
                int ends[2], k = 0;
                for (int j = 0; j < 4; ++j)
                    if (j != i && cell.vertices[j] != apex_)
                        ends[k++] = cell.vertices[j];
                call(std::min(ends[0], ends[1]), std::max(ends[0], ends[1]), t, neighbour);
            }
        }
    }

    /// Of the angle at which a point sees two others.
    double cosine_at(int v, int a, int b) const
    {
        return (points_[a] - points_[v]).normalized().dot((points_[b] - points_[v]).normalized());
    }

    /// Angle at which a triangle's circumcentre sees an edge; 0 from outside.
    double angle_at(int t, int a, int b) const
    {
        if (t == outside())
            return 0;
        const Vector u = points_[a] - cells_.centres[t], v = points_[b] - cells_.centres[t];
        return std::atan2(std::abs(u.x() * v.y() - u.y() * v.x()), u.x() * v.x() + u.y() * v.y());
    }

private:
    int apex_;
    Points points_;
    Triangulation cells_;
};

struct Rims
{
    std::set<std::pair<int, int>> edges;
    std::vector<std::vector<int>> mates; ///< Per point: its two neighbours, or fewer.
};

Rims join_rims(const PlanarTriangulation& planar, int points)
{
    struct Edge
    {
        double length;
        int a, b;
        bool operator<(const Edge& other) const
        {
            return std::make_pair(length, std::make_pair(a, b)) <
                   std::make_pair(other.length, std::make_pair(other.a, other.b));
        }
    };
    std::vector<Edge> crust, others;
    planar.for_edges(
        [&](int a, int b, int t, int neighbour)
        {
            const bool is_crust = planar.angle_at(t, a, b) + planar.angle_at(neighbour, a, b) < pi;
            (is_crust ? crust : others).push_back({planar.length(a, b), a, b});
        });
    DisjointSets chains{std::size_t(points)};
    std::vector<int> size(std::size_t(points), 1);
    Rims result;
    result.mates.resize(std::size_t(points));
    for (auto* edges : {&crust, &others})
    {
        std::sort(edges->begin(), edges->end());
        for (const Edge& e : *edges)
            if (result.mates[e.a].size() < 2 && result.mates[e.b].size() < 2 &&
                (chains.find(e.a) != chains.find(e.b) || size[chains.find(e.a)] >= fewest_in_loop))
            {
                const int both = size[chains.find(e.a)] + size[chains.find(e.b)];
                if (chains.join(e.a, e.b))
                    size[chains.find(e.a)] = both;
                result.mates[e.a].push_back(e.b);
                result.mates[e.b].push_back(e.a);
                result.edges.insert({e.a, e.b});
            }
    }
    return result;
}

/// Exchanges edges while that makes rims straighter: where two come nearer to each other than their samples, the
/// shortest edges lead from one to the other, but only by sharp turns.
class RimStraightener
{
public:
    RimStraightener(const PlanarTriangulation& planar, Rims& rims) : planar_(planar), rims_(rims)
    {
        planar.for_edges([&](int a, int b, int, int) { edges_.insert({a, b}); });
        std::vector<double> lengths;
        for (const auto& [a, b] : rims.edges)
            lengths.push_back(planar.length(a, b));
        unit_ = lengths.empty() ? 1 : median(std::move(lengths));
    }

    void straighten()
    {
        bool is_changed = true;
        for (int round = 0; is_changed && round < most_exchanges; ++round)
        {
            is_changed = false;
            for (const auto& [a, c] : edges_)
                is_changed |= !is_rim(a, c) && try_edge(a, c);
        }
    }

private:
    bool is_rim(int a, int b) const { return rims_.edges.count(std::minmax(a, b)) > 0; }
    bool is_edge(int a, int b) const { return edges_.count(std::minmax(a, b)) > 0; }

    void link(int a, int b)
    {
        rims_.mates[a].push_back(b);
        rims_.mates[b].push_back(a);
        rims_.edges.insert(std::minmax(a, b));
    }
    void cut(int a, int b)
    {
        auto& of_a = rims_.mates[a];
        auto& of_b = rims_.mates[b];
        of_a.erase(std::find(of_a.begin(), of_a.end(), b));
        of_b.erase(std::find(of_b.begin(), of_b.end(), a));
        rims_.edges.erase(std::minmax(a, b));
    }

    double cost_at(int v) const
    {
        const auto& mates = rims_.mates[v];
        double cost = open_end * double(2 - int(mates.size()));
        for (const int m : mates)
            cost += 0.5 * length_cost * planar_.length(v, m) / unit_;
        return mates.size() < 2 ? cost : cost + 1 + planar_.cosine_at(v, mates[0], mates[1]);
    }

    /// Links two points, each of which gives up a mate for that; the two mates are linked if they are neighbours.
    /// \returns whether that was better; else all is as before.
    bool try_edge(int a, int c)
    {
        const std::vector<int> of_a = list_given_up(a), of_c = list_given_up(c);
        for (const int b : of_a)
            for (const int d : of_c)
                for (const bool is_closed : {true, false})
                {
                    if (is_closed && (b < 0 || d < 0 || b == d || !is_edge(b, d) || is_rim(b, d)))
                        continue;
                    if (improves(a, b, c, d, is_closed))
                        return true;
                }
        return false;
    }

    std::vector<int> list_given_up(int v) const
    {
        return rims_.mates[v].size() < 2 ? std::vector<int>{-1} : rims_.mates[v];
    }

    bool improves(int a, int b, int c, int d, bool is_closed)
    {
        const auto cost = [&]
        { return cost_at(a) + cost_at(c) + (b < 0 ? 0 : cost_at(b)) + (d < 0 || d == b ? 0 : cost_at(d)); };
        const double before = cost();
        if (b >= 0)
            cut(a, b);
        if (d >= 0)
            cut(c, d);
        link(a, c);
        if (is_closed)
            link(b, d);
        if (cost() < before - least_gain)
            return true;
        if (is_closed)
            cut(b, d);
        cut(a, c);
        if (d >= 0)
            link(c, d);
        if (b >= 0)
            link(a, b);
        return false;
    }

    const PlanarTriangulation& planar_;
    Rims& rims_;
    std::set<std::pair<int, int>> edges_;
    double unit_;
};

/// Points of chains that do not close.
std::vector<int> list_open_chains(const Rims& rims)
{
    DisjointSets chains(rims.mates.size());
    for (const auto& e : rims.edges)
        chains.join(e.first, e.second);
    std::set<std::size_t> open;
    for (std::size_t v = 0; v < rims.mates.size(); ++v)
        if (rims.mates[v].size() < 2)
            open.insert(chains.find(v));
    std::vector<int> result;
    for (std::size_t v = 0; v < rims.mates.size(); ++v)
        if (open.count(chains.find(v)) > 0)
            result.push_back(int(v));
    return result;
}

std::vector<int> list_strays(const PlanarTriangulation& planar, const Rims& rims, bool expected)
{
    std::vector<double> lengths;
    for (const auto& e : rims.edges)
        lengths.push_back(planar.length(e.first, e.second));
    const double limit = expected && !lengths.empty() ? far_from_rim * median(std::move(lengths)) : 1e300;
    std::vector<int> result;
    for (int v = 0; v < int(rims.mates.size()); ++v)
    {
        const auto& mates = rims.mates[v];
        if (mates.size() < 2 || std::min(planar.length(v, mates[0]), planar.length(v, mates[1])) > limit)
            result.push_back(v);
    }
    return result;
}

std::vector<PlanarFace> fill_by_parity(const PlanarTriangulation& planar, const Rims& rims)
{
    SignedGraph graph;
    graph.nodes = planar.triangles() + 1;
    graph.is_root.assign(std::size_t(graph.nodes), 0);
    graph.is_root[planar.outside()] = 1;
    DisjointSets regions(std::size_t(graph.nodes));
    planar.for_edges(
        [&](int a, int b, int t, int neighbour)
        {
            if (rims.edges.count({a, b}) > 0)
                graph.edges.push_back({t, neighbour, -1});
            else if (regions.join(t, neighbour))
                graph.merged.push_back({t, neighbour});
        });
    const std::vector<Side> labels = label_by_contraction(graph);
    if (measure_violated_repulsion(graph.edges, labels).share() > contradictory)
        return {};
    std::map<int, PlanarFace> faces;
    for (int t = 0; t < planar.triangles(); ++t)
        if (labels[t] == Side::inner)
            faces[regions.find(t)].triangles.push_back(planar.triangle(t));
    planar.for_edges(
        [&](int a, int b, int t, int neighbour)
        {
            if (rims.edges.count({a, b}) == 0)
                return;
            for (const int side : {t, neighbour})
                if (labels[side] == Side::inner)
                {
                    auto& rim = faces[regions.find(side)].rim;
                    rim.insert(rim.end(), {a, b});
                }
        });
    std::vector<PlanarFace> result;
    for (auto& face : faces)
    {
        auto& rim = face.second.rim;
        std::sort(rim.begin(), rim.end());
        rim.erase(std::unique(rim.begin(), rim.end()), rim.end());
        result.push_back(std::move(face.second));
    }
    return result;
}

} // namespace

std::vector<PlanarFace> fill_planar_rims(const std::vector<Eigen::Vector2d>& points, double strays)
{
    std::vector<int> kept(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        kept[i] = int(i);
    const double fewest = (1 - strays) * double(points.size());
    for (int round = 0; kept.size() >= 3 && double(kept.size()) >= fewest; ++round)
    {
        std::vector<Eigen::Vector2d> present;
        for (const int i : kept)
            present.push_back(points[i]);
        const PlanarTriangulation planar(present);
        Rims rims = join_rims(planar, int(present.size()));
        RimStraightener(planar, rims).straighten();
        const std::vector<int> left_out =
            round < rounds_of_strays ? list_strays(planar, rims, strays > 0) : list_open_chains(rims);
        if (left_out.empty())
        {
            std::vector<PlanarFace> faces = fill_by_parity(planar, rims);
            for (PlanarFace& face : faces)
            {
                for (auto& t : face.triangles)
                    t = {kept[t[0]], kept[t[1]], kept[t[2]]};
                for (int& v : face.rim)
                    v = kept[v];
            }
            return faces;
        }
        for (auto v = left_out.rbegin(); v != left_out.rend(); ++v)
            kept.erase(kept.begin() + *v);
    }
    return {};
}

std::vector<std::array<int, 2>> list_border_edges(const std::vector<std::array<int, 3>>& triangles)
{
    std::map<std::array<int, 2>, int> uses;
    for (const auto& t : triangles)
        for (int i = 0; i < 3; ++i)
        {
            const auto [low, high] = std::minmax(t[i], t[(i + 1) % 3]);
            ++uses[{low, high}];
        }
    std::vector<std::array<int, 2>> border;
    for (const auto& [edge, count] : uses)
        if (count == 1)
            border.push_back(edge);
    return border;
}

} // namespace recon
