#include "orient.h"

#include "filter_amls/paper/feature_size.h"
#include "label_balls.h"
#include "turn_patches.h"
#include "turn_pieces.h"

#include <recon/mesh/level_sheet.h>
#include <recon/parallel.h>
#include <recon/search/block_search.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

namespace recon
{
namespace
{

constexpr double big_spacings = 3; // a ball of this many spacings is fully trusted
constexpr double opposite_weight = 0.98;
constexpr int vote_rounds = 6;
constexpr int vote_neighbours = 12;
constexpr double least_vote = 0.1;
/// Of a landmark's own vote beside one neighbour's: on thin parts neighbours may be of the other sheet, its balls not.
constexpr double own_weight = 6;
constexpr double off_sheet = 0.85;   // spacings over the tangent plane: neighbours beyond may be of another sheet
constexpr double gap_spacings = 8;   // an edge this long spans a gap
constexpr double open_share = 0.3;   // of the area: single views have .38 to .67, closed models and busts up to .18
constexpr double towards_box = 1000; // weight of facets between the cloud and the box over a ground: none is cut
/// Share of points in patches that had to be turned above which the cloud is an open sheet that bends back, whatever
/// its gaps: 0.1 to 0.5 where sheets do.
constexpr double bent_back = 0.1;

/// The balls of a Delaunay triangulation and their ties.
struct Balls
{
    Triangulation delaunay;
    std::vector<double> radius; ///< Per finite cell.
    std::vector<double> big;    ///< Per finite cell: how far to trust that it is no gap between samples [0..1].
    /// Per point: farthest ball centre along and against the normal, as finite cells; -1 if there is none.
    std::vector<int> outer, inner;
};

double intersection_cosine(double r1, double r2, double squared_distance)
{
    return (r1 * r1 + r2 * r2 - squared_distance) / (2 * r1 * r2);
}

Balls make_balls(const Points& points, const Vectors& normals, const std::vector<double>& spacing, int threads,
                 const Progress& progress)
{
    const int n = int(points.size());
    Balls balls;
    PolarCells polar = find_polar_cells(points, normals, threads, progress);
    balls.delaunay = std::move(polar.delaunay);
    balls.outer = std::move(polar.outer);
    balls.inner = std::move(polar.inner);
    const Triangulation& t = balls.delaunay;
    balls.radius.resize(t.finite_cells);
    balls.big.resize(t.finite_cells);
    parallel_for(
        std::size_t(t.finite_cells), threads, {},
        [&](std::size_t c)
        {
            const auto& vertices = t.cells[c].vertices;
            double local = 0;
            int count = 0;
            for (int v : vertices)
                if (v < n)
                {
                    local += spacing[v];
                    ++count;
                    balls.radius[c] = (t.centres[c] - points[v]).norm();
                }
            if (count == 0)
                balls.radius[c] = 4 * t.centres[c].norm() + 4; // between corners of the box only
            balls.big[c] = count == 0 ? 1 : std::min(1.0, balls.radius[c] / (big_spacings * local / count));
        },
        4096);
    return balls;
}

/// How well the direction from a point to a ball's centre agrees with a unit normal, in absolute value.
double pole_cosine(const Balls& balls, const Points& points, const Vectors& normals, int v, int cell)
{
    return std::abs((balls.delaunay.centres[cell] - points[v]).dot(normals[v])) / std::max(balls.radius[cell], 1e-300);
}

/// Whether a cell is one of the few at the sides of the box, which lie outside whatever ties say: as a tie of some
/// weight that was outvoted by a thin plate.
bool is_outermost(const Triangulation& t, int cell)
{
    const auto& neighbours = t.cells[cell].neighbours;
    return std::any_of(neighbours.begin(), neighbours.end(), [&](int o) { return !t.is_finite(o); });
}

/// An open cloud over a ground, below which there is no ball to be inside: its two sides are not opposite.
struct GroundedCloud
{
    std::vector<char> is_ground; ///< Per point.
    const std::vector<double>& spacing;

    /// How much a facet between two balls counts. Of things that were seen from above only the sides are bare, and the
    /// few large balls there would let the surface leave them for a tent down to the rim of the ground; so what is bare
    /// counts by its area in samples, to the power of 2/3: by all of it, sides would be more than the top of a table.
    double weigh(const Triangulation& t, const Points& points, int cell, int facet) const
    {
        const auto& v = t.cells[cell].vertices;
        const int a = v[(facet + 1) % 4], b = v[(facet + 2) % 4], c = v[(facet + 3) % 4];
        if (std::max({a, b, c}) >= int(points.size()))
            return towards_box;
        const double side = (spacing[a] + spacing[b] + spacing[c]) / 3;
        const double area = 0.5 * (points[b] - points[a]).cross(points[c] - points[a]).norm() / (side * side);
        return std::max(1.0, std::cbrt(area * area));
    }
};

/// Between balls by cell, the outermost ones as the outside, which is the number of finite cells. \param grounded may
/// be null.
std::vector<Tie> list_ties(const Balls& balls, const Points& points, const Vectors& normals,
                           const GroundedCloud* grounded, int threads)
{
    const Triangulation& t = balls.delaunay;
    const int outside = t.finite_cells;
    const auto tie = [&](int a, int b, double weight, bool opposite, std::vector<Tie>& ties)
    {
        a = is_outermost(t, a) ? outside : a;
        b = is_outermost(t, b) ? outside : b;
        if (weight > 0 && a != b)
            ties.push_back({a, b, float(weight), opposite});
    };
    const auto tie_neighbours = [&](int c, std::vector<Tie>& ties)
    {
        for (int i = 0; i < 4; ++i)
        {
            const int o = t.cells[c].neighbours[i];
            if (!t.is_finite(o) || o <= c)
                continue;
            const double cosine =
                intersection_cosine(balls.radius[c], balls.radius[o], (t.centres[c] - t.centres[o]).squaredNorm());
            const double size = grounded ? grounded->weigh(t, points, c, i) : 1;
            tie(c, o, size * cosine * std::min(balls.big[c], balls.big[o]), false, ties);
        }
    };
    const auto tie_opposites = [&](int v, std::vector<Tie>& ties)
    {
        const int a = balls.outer[v], b = balls.inner[v];
        if (a < 0 || b < 0 || (grounded && grounded->is_ground[v]))
            return;
        const double weight =
            opposite_weight *
            std::min(pole_cosine(balls, points, normals, v, a), pole_cosine(balls, points, normals, v, b)) *
            std::min(balls.big[a], balls.big[b]);
        tie(a, b, weight, true, ties);
    };
    return parallel_collect<Tie>(
        std::size_t(t.finite_cells) + points.size(), threads, {},
        [&](std::size_t i, std::vector<Tie>& ties)
        {
            if (int(i) < t.finite_cells)
                tie_neighbours(int(i), ties);
            else
                tie_opposites(int(i) - t.finite_cells, ties);
        },
        8192);
}

/// Flips normals that the 12 points around them contradict more than their own balls confirm, beginning where
/// neighbours in the triangulation contradict each other, since elsewhere all agree.
void settle_votes(const Triangulation& t, const Points& points, const std::vector<double>& vote,
                  const std::vector<double>& spacing, int threads, Vectors& normals)
{
    const int n = int(points.size());
    std::vector<char> doubtful(n, 0);
    for (int c = 0; c < t.finite_cells; ++c)
    {
        const auto& v = t.cells[c].vertices;
        for (int i = 0; i < 4; ++i)
            for (int j = i + 1; j < 4; ++j)
                if (v[i] < n && v[j] < n && normals[v[i]].dot(normals[v[j]]) < 0)
                    doubtful[v[i]] = doubtful[v[j]] = 1;
    }
    const BlockSearch search(points, threads);
    for (int round = 0; round < vote_rounds; ++round)
    {
        std::vector<int> asked;
        for (int v = 0; v < n; ++v)
            if (doubtful[v])
                asked.push_back(v);
        std::vector<std::uint8_t> flip(asked.size(), 0);
        std::vector<int> near(asked.size() * (vote_neighbours + 1), -1);
        parallel_for(
            asked.size(), threads, {},
            [&](std::size_t i)
            {
                const int v = asked[i];
                double squared[vote_neighbours + 1];
                int* found = &near[i * (vote_neighbours + 1)];
                double reach = 2.5 * spacing[v];
                const int count = search.nearest(points[v], vote_neighbours + 1, found, squared, reach);
                double agreement = least_vote + own_weight * std::abs(vote[v]);
                for (int k = 1; k < count; ++k) // the first is the landmark itself
                {
                    const double off = normals[v].dot(points[found[k]] - points[v]) / (off_sheet * spacing[v]);
                    const double on_sheet = 1 / (1 + off * off);
                    agreement += on_sheet * on_sheet * normals[v].dot(normals[found[k]]) *
                                 (least_vote + std::abs(vote[found[k]]));
                }
                flip[i] = agreement < 0;
            },
            256);
        int flips = 0;
        for (std::size_t i = 0; i < asked.size(); ++i)
            if (flip[i])
            {
                normals[asked[i]] = -normals[asked[i]];
                ++flips;
                for (int k = 0; k <= vote_neighbours; ++k)
                    if (near[i * (vote_neighbours + 1) + std::size_t(k)] >= 0)
                        doubtful[near[i * (vote_neighbours + 1) + std::size_t(k)]] = 1;
            }
        if (flips == 0)
            break;
    }
}

/// Share of the area of the surface between the two sides that spans gaps between the points, or has behind it what
/// reaches out to the box: nothing but small holes if the cloud is closed, as much as the cloud itself if it is a
/// sheet.
double measure_gaps(const Triangulation& t, const Points& points, const std::vector<double>& spacing,
                    const std::vector<std::int8_t>& side)
{
    const int n = int(points.size());
    enum Place : char
    {
        outside,
        inside,
        inside_to_box
    };
    std::vector<Place> place(t.finite_cells, outside);
    for (int c = 0; c < t.finite_cells; ++c)
        if (side[c] < 0)
        {
            const auto& v = t.cells[c].vertices;
            place[c] = std::any_of(v.begin(), v.end(), [n](int i) { return i >= n; }) ? inside_to_box : inside;
        }
    double total = 0, gaps = 0;
    for (int c = 0; c < t.finite_cells; ++c)
    {
        if (place[c] == outside)
            continue;
        for (int i = 0; i < 4; ++i)
        {
            const int o = t.cells[c].neighbours[i];
            const Place beyond = t.is_finite(o) ? place[o] : outside;
            if (beyond == inside || beyond == place[c])
                continue;
            const auto& v = t.cells[c].vertices;
            const int a = v[(i + 1) % 4], b = v[(i + 2) % 4], d = v[(i + 3) % 4];
            if (a >= n || b >= n || d >= n)
                continue;
            const Vector ab = points[b] - points[a], ad = points[d] - points[a], bd = points[d] - points[b];
            const double area = ab.cross(ad).norm();
            const double longest = std::max({ab.squaredNorm(), ad.squaredNorm(), bd.squaredNorm()});
            const double wide = gap_spacings / 3 * (spacing[a] + spacing[b] + spacing[d]);
            total += area;
            if (place[c] == inside_to_box || beyond == inside_to_box || longest > wide * wide)
                gaps += area;
        }
    }
    return total > 0 ? gaps / total : 0;
}

BallLabels label(const Balls& balls, const std::vector<Tie>& ties, int threads, const Progress& progress)
{
    const Triangulation& t = balls.delaunay;
    BallLabels labels = label_balls(t.finite_cells, ties, threads, progress);
    for (int c = 0; c < t.finite_cells; ++c)
        if (is_outermost(t, c))
            labels.side[c] = 1;
    return labels;
}

/// Per point: how far its balls agree that its normal points outward (> 0) or inward [-2..2].
std::vector<double> ask_balls(const Balls& balls, const Points& points, const Vectors& normals,
                              const std::vector<std::int8_t>& side, int threads)
{
    std::vector<double> vote(points.size(), 0);
    const auto trust = [&](std::size_t v, int cell)
    { return cell < 0 ? 0 : side[cell] * balls.big[cell] * pole_cosine(balls, points, normals, int(v), cell); };
    parallel_for(
        points.size(), threads, {},
        [&](std::size_t v) { vote[v] = trust(v, balls.outer[v]) - trust(v, balls.inner[v]); }, 4096);
    return vote;
}

Vectors turn_by(const std::vector<double>& vote, Vectors normals)
{
    for (std::size_t v = 0; v < normals.size(); ++v)
        if (vote[v] < 0)
            normals[v] = -normals[v];
    return normals;
}

} // namespace

Orientation orient_normals(const Points& points, const Vectors& normals, const std::vector<double>& spacing,
                           int threads, const Progress& progress)
{
    const int n = int(points.size());
    const Balls balls = make_balls(points, normals, spacing, threads, progress.part(0, 0.6, "Delaunay triangulation"));
    const Triangulation& t = balls.delaunay;
    const Progress sides = progress.part(0.6, 1, "Orientation");
    sides.report(0);
    BallLabels labels = label(balls, list_ties(balls, points, normals, nullptr, threads), threads, sides.part(0, 0.4));

    Orientation result;
    result.contradicted = labels.contradicted;
    std::vector<double> vote = ask_balls(balls, points, normals, labels.side, threads);
    result.normals = turn_by(vote, normals);
    result.open = measure_gaps(t, points, spacing, labels.side) > open_share;
    sides.report(0.4);
    const std::optional<Ground> ground =
        result.open ? find_ground(points, times_area(result.normals, spacing)) : std::nullopt;
    if (ground)
    {
        const Vector up = ground->faces_things ? ground->normal : -ground->normal;
        GroundedCloud grounded{std::vector<char>(n, 0), spacing};
        for (const int v : ground->members)
            grounded.is_ground[v] = 1;
        labels = label(balls, list_ties(balls, points, normals, &grounded, threads), threads, sides.part(0.4, 0.6));
        result.contradicted = labels.contradicted;
        vote = ask_balls(balls, points, normals, labels.side, threads);
        for (const int v : ground->members)
            vote[v] = normals[v].dot(up) < 0 ? -1 : 1;
        result.normals = turn_by(vote, normals);
    }
    settle_votes(t, points, vote, spacing, threads, result.normals);
    sides.report(0.7);
    result.open |= turn_patches(t, points, spacing, ground.has_value(), result.normals, threads) > bent_back;
    sides.report(0.8);
    result.is_closed =
        result.open ? turn_closed_pieces(t, points, spacing, result.normals) : std::vector<char>(points.size(), 0);
    if (!ground)
        turn_outward(points, spacing, result.open, result.is_closed, result.normals);
    sides.report(0.9);
    result.poles = select_poles(t, points, normals, spacing, balls.outer, balls.inner);
    return result;
}

} // namespace recon
