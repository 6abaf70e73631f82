#include <recon/bare_faces/planar_faces.h>

#include <recon/disjoint_sets.h>
#include <recon/geometry.h>
#include <recon/labelling/signed_labelling.h>
#include <recon/median.h>
#include <recon/triangulation/delaunay.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
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

/// Share of the points on a line that are nearly all, and points whose joining lines are asked for it.
constexpr double nearly_all = 0.9;
constexpr std::size_t joined_by_lines = 8;

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

/// The neighbours of a point on its rim: two or fewer, for a moment three, in the order in which they came.
class Mates
{
public:
    const int* begin() const { return points_; }
    const int* end() const { return points_ + count_; }
    int size() const { return count_; }
    int operator[](int i) const { return points_[i]; }
    bool contains(int point) const { return std::find(begin(), end(), point) != end(); }
    void add(int point) { points_[count_++] = point; }
    void remove(int point)
    {
        int* const found = std::find(points_, points_ + count_, point);
        std::copy(found + 1, points_ + count_, found);
        --count_;
    }

private:
    int points_[3] = {-1, -1, -1};
    int count_ = 0;
};

struct Rims
{
    std::vector<Mates> mates; ///< Per point.

    bool has_edge(int a, int b) const { return mates[a].contains(b); }
    /// Calls call(a, b) with a < b for every edge once.
    template <class Call>
    void for_edges(Call&& call) const
    {
        for (int a = 0; a < int(mates.size()); ++a)
            for (const int b : mates[a])
                if (a < b)
                    call(a, b);
    }
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
                result.mates[e.a].add(e.b);
                result.mates[e.b].add(e.a);
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
        planar.for_edges([&](int a, int b, int, int) { edges_.emplace_back(a, b); });
        std::sort(edges_.begin(), edges_.end());
        std::vector<double> lengths;
        rims.for_edges([&](int a, int b) { lengths.push_back(planar.length(a, b)); });
        unit_ = lengths.empty() ? 1 : median(std::move(lengths));
    }

    void straighten()
    {
        changed_.assign(rims_.mates.size(), 0);
        std::vector<int> tried(edges_.size(), -1);
        bool is_changed = true;
        for (int round = 0; is_changed && round < most_exchanges; ++round)
        {
            is_changed = false;
            for (std::size_t e = 0; e < edges_.size(); ++e)
            {
                const auto [a, c] = edges_[e];
                // What was no gain is none until an edge at its points or at their mates is exchanged.
                if (rims_.has_edge(a, c) || std::max(last_change(a), last_change(c)) <= tried[e])
                    continue;
                tried[e] = exchanges_;
                is_changed |= try_edge(a, c);
            }
        }
    }

private:
    bool is_edge(int a, int b) const
    {
        return std::binary_search(edges_.begin(), edges_.end(), std::pair<int, int>(std::minmax(a, b)));
    }

    /// At a point or at its mates.
    int last_change(int v) const
    {
        int result = changed_[v];
        for (const int m : rims_.mates[v])
            result = std::max(result, changed_[m]);
        return result;
    }

    void link(int a, int b)
    {
        rims_.mates[a].add(b);
        rims_.mates[b].add(a);
    }
    void cut(int a, int b)
    {
        rims_.mates[a].remove(b);
        rims_.mates[b].remove(a);
    }

    double cost_at(int v) const
    {
        const Mates& mates = rims_.mates[v];
        double cost = open_end * double(2 - mates.size());
        for (const int m : mates)
            cost += 0.5 * length_cost * planar_.length(v, m) / unit_;
        return mates.size() < 2 ? cost : cost + 1 + planar_.cosine_at(v, mates[0], mates[1]);
    }

    /// Links two points, each of which gives up a mate for that; the two mates are linked if they are neighbours.
    /// \returns whether that was better; else all is as before.
    bool try_edge(int a, int c)
    {
        const Mates of_a = list_given_up(a), of_c = list_given_up(c);
        for (const int b : of_a)
            for (const int d : of_c)
                for (const bool is_closed : {true, false})
                {
                    if (is_closed && (b < 0 || d < 0 || b == d || rims_.has_edge(b, d) || !is_edge(b, d)))
                        continue;
                    if (improves(a, b, c, d, is_closed))
                        return true;
                }
        return false;
    }

    Mates list_given_up(int v) const
    {
        if (rims_.mates[v].size() == 2)
            return rims_.mates[v];
        Mates none;
        none.add(-1);
        return none;
    }

    bool improves(int a, int b, int c, int d, bool is_closed)
    {
        const auto cost = [&]
        { return cost_at(a) + cost_at(c) + (b < 0 ? 0 : cost_at(b)) + (d < 0 || d == b ? 0 : cost_at(d)); };
        const double before = cost();
        const std::array<int, 4> points = {a, c, b < 0 ? a : b, d < 0 ? c : d};
        std::array<Mates, 4> mates;
        for (int k = 0; k < 4; ++k)
            mates[k] = rims_.mates[points[k]];
        if (b >= 0)
            cut(a, b);
        if (d >= 0)
            cut(c, d);
        link(a, c);
        if (is_closed)
            link(b, d);
        if (cost() < before - least_gain)
        {
            ++exchanges_;
            for (const int v : points)
                changed_[v] = exchanges_;
            return true;
        }
        for (int k = 0; k < 4; ++k)
            rims_.mates[points[k]] = mates[k];
        return false;
    }

    const PlanarTriangulation& planar_;
    Rims& rims_;
    std::vector<std::pair<int, int>> edges_; ///< Of the triangulation, ascending.
    double unit_;
    int exchanges_ = 0;
    std::vector<int> changed_; ///< Per point: number of exchanges at its last one.
};

/// Points of chains that do not close.
std::vector<int> list_open_chains(const Rims& rims)
{
    DisjointSets chains(rims.mates.size());
    rims.for_edges([&](int a, int b) { chains.join(a, b); });
    std::vector<char> is_open(rims.mates.size(), 0);
    for (int v = 0; v < int(rims.mates.size()); ++v)
        if (rims.mates[v].size() < 2)
            is_open[chains.find(v)] = 1;
    std::vector<int> result;
    for (int v = 0; v < int(rims.mates.size()); ++v)
        if (is_open[chains.find(v)])
            result.push_back(v);
    return result;
}

std::vector<int> list_strays(const PlanarTriangulation& planar, const Rims& rims, bool expected)
{
    std::vector<double> lengths;
    rims.for_edges([&](int a, int b) { lengths.push_back(planar.length(a, b)); });
    const double limit = expected && !lengths.empty() ? far_from_rim * median(std::move(lengths)) : 1e300;
    std::vector<int> result;
    for (int v = 0; v < int(rims.mates.size()); ++v)
    {
        const Mates& mates = rims.mates[v];
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
            if (rims.has_edge(a, b))
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
            if (!rims.has_edge(a, b))
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

PlanarFaces fill_planar_rims(const std::vector<Eigen::Vector2d>& points, double strays)
{
    std::vector<int> kept(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        kept[i] = int(i);
    for (int round = 0; kept.size() >= 3 && are_all_but(strays, kept.size(), points.size()); ++round)
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
            return {std::move(faces), kept.size()};
        }
        for (const int v : left_out)
            kept[v] = -1;
        kept.erase(std::remove(kept.begin(), kept.end(), -1), kept.end());
    }
    return {};
}

bool lie_on_a_line(const std::vector<Eigen::Vector2d>& points, double tolerance)
{
    const std::size_t stride = points.size() / joined_by_lines + 1;
    for (std::size_t a = 0; a < points.size(); a += stride)
        for (std::size_t b = a + stride; b < points.size(); b += stride)
        {
            const Eigen::Vector2d along = points[b] - points[a];
            const double limit = tolerance * along.norm();
            const auto on_line = std::count_if(points.begin(), points.end(),
                                               [&](const Eigen::Vector2d& p)
                                               {
                                                   const Eigen::Vector2d off = p - points[a];
                                                   return std::abs(along.x() * off.y() - along.y() * off.x()) < limit;
                                               });
            if (double(on_line) > nearly_all * double(points.size()))
                return true;
        }
    return false;
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
