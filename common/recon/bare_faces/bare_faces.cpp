#include <recon/bare_faces/bare_faces.h>

#include <recon/errors.h>
#include <recon/labelling/minimum_cut.h>
#include <recon/parallel.h>
#include <recon/scramble.h>
#include <recon/search/block_search.h>
#include <recon/search/keep_apart.h>
#include <recon/search/neighbours.h>
#include <recon/triangulation/delaunay.h>
#include <recon/triangulation/triangulation.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace recon
{
namespace
{

/// Longest side of a bare facet at least [spacings at its corners].
constexpr double bare_side = 3;
/// Radius of the disks of new samples: of the spacing at the nearest sample, or this share of its distance.
constexpr double disk = 0.8, disk_by_distance = 0.3;
/// New samples keep this off the others [spacings there].
constexpr double apart = 0.7;
/// Pieces that facets are cut into, at most [per sample; count]; 80 per sample between rounded corners, 430 and more
/// between two circles of 2,500 samples.
constexpr std::size_t most_pieces_per_sample = 250, most_pieces = 4'000'000;
/// Of these, as many more where not all are kept.
constexpr std::size_t more_if_thinned = 3;
/// Cosine to a sample's normal within which a Voronoi vertex may be its pole.
constexpr double pole_within = 0.7;

/// Share of violated votes above which faces may be missing (slices reach 0.009), and most points of a cloud that is
/// asked [count].
constexpr double objecting = 0.01;
constexpr std::size_t most_points = 200'000;
/// Share of the violated votes that may be left: 0.002 to 0.23 where parts became whole, 0.34 to 0.9 where bores, walls
/// and hollows were filled or nothing was gained. And most of the cut's own ties that it may contradict: up to 0.045,
/// and 0.055 and more.
constexpr double clearly_fewer = 0.25, bearable = 0.05;
/// Bare share of the boundary at least: 0.33 and more where parts became whole, 0.13 to 0.24 of cups, rooms and
/// turbine.
constexpr double much = 0.3;
/// The same of an open sheet: it and the lid that closes it share the area.
constexpr double more_than_lids = 0.6;

using Facet = std::array<int, 3>;

/// Delaunay tetrahedra as nodes of a cut, with one more for all without.
class TetrahedronCut
{
public:
    TetrahedronCut(const Points& samples, const Vectors& normals, int threads, const Progress& progress)
        : samples_(samples), normals_(normals), delaunay_(triangulate_delaunay(samples, progress, threads)),
          at_(list_cells_at_vertices(delaunay_, int(samples.size()), threads)), without_(delaunay_.finite_cells)
    {
        SignedGraph graph;
        graph.nodes = without_ + 1;
        graph.is_root.assign(std::size_t(graph.nodes), 0);
        graph.is_root[std::size_t(without_)] = 1;
        for (int cell = 0; cell < without_; ++cell)
            for (int k = 0; k < 4; ++k)
                if (const int other = node(delaunay_.cells[std::size_t(cell)].neighbours[std::size_t(k)]); other > cell)
                    graph.edges.push_back({cell, other, weigh(cell, k, other)});
        std::vector<TerminalTie> ties;
        int fixed = 0;
        for (std::size_t i = 0; i < samples.size(); ++i)
            for (const Side side : {Side::outer, Side::inner})
            {
                const Vector towards = side == Side::outer ? normals[i] : Vector(-normals[i]);
                const int beside = find_beside(int(i), towards);
                for (const int cell : {beside, beside == without_ ? without_ : find_pole(int(i), towards)})
                    if (cell == without_)
                        fixed += side == Side::inner;
                    else if (cell >= 0)
                        ties.push_back({cell, side, 1});
            }
        labels_ = label_by_minimum_cut(graph, ties);
        const auto wrong =
            std::count_if(ties.begin(), ties.end(),
                          [&](const TerminalTie& tie) { return labels_[std::size_t(tie.node)] != tie.side; });
        contradicted_ = double(wrong + fixed) / double(std::max<std::size_t>(1, ties.size() + std::size_t(fixed)));
    }

    double contradicted() const { return contradicted_; }

    /// Facets between inner and outer tetrahedra, counter-clockwise seen from without.
    std::vector<Facet> list_boundary() const
    {
        std::vector<Facet> result;
        for (int cell = 0; cell < without_; ++cell)
        {
            if (labels_[std::size_t(cell)] == Side::outer)
                continue;
            const auto& [vertices, neighbours] = delaunay_.cells[std::size_t(cell)];
            for (int k = 0; k < 4; ++k)
                if (labels_[std::size_t(node(neighbours[std::size_t(k)]))] == Side::outer)
                    result.push_back(facet(vertices, k));
        }
        return result;
    }

private:
    int node(int cell) const { return delaunay_.is_finite(cell) ? cell : without_; }
    const Point& at(int vertex) const { return samples_[std::size_t(vertex)]; }

    /// Opposite vertex k, counter-clockwise seen from the other side of it.
    Facet facet(const std::array<int, 4>& vertices, int k) const
    {
        Facet f;
        for (int i = 0, n = 0; i < 4; ++i)
            if (i != k)
                f[std::size_t(n++)] = vertices[std::size_t(i)];
        const Vector normal = (at(f[1]) - at(f[0])).cross(at(f[2]) - at(f[0]));
        if (normal.dot(at(vertices[std::size_t(k)]) - at(f[0])) > 0)
            std::swap(f[1], f[2]);
        return f;
    }

    /// 1 - the least cosine of the angles at which a facet meets the two spheres: next to nothing for one that the
    /// smallest sphere through its corners has on its equator, without samples in it.
    double weigh(int cell, int k, int other) const
    {
        constexpr double at_least = 1e-6;
        const Facet f = facet(delaunay_.cells[std::size_t(cell)].vertices, k);
        const Vector away = (at(f[1]) - at(f[0])).cross(at(f[2]) - at(f[0])).normalized();
        const auto cosine = [&](int of, double side)
        {
            const Vector radius = delaunay_.centres[std::size_t(of)] - at(f[0]);
            return side * radius.dot(away) / radius.norm();
        };
        const double within = cosine(cell, -1), beyond = other == without_ ? 1 : cosine(other, 1);
        return 1 - std::min(within, beyond) + at_least;
    }

    /// The tetrahedron at a sample into which a direction leads.
    int find_beside(int sample, const Vector& towards) const
    {
        int best = without_;
        double most = -1e-9;
        for (int k = at_.first[std::size_t(sample)]; k < at_.first[std::size_t(sample) + 1]; ++k)
        {
            const int cell = at_.cell[std::size_t(k)];
            if (!delaunay_.is_finite(cell))
                continue;
            std::array<Vector, 3> edges;
            int n = 0;
            for (const int v : delaunay_.cells[std::size_t(cell)].vertices)
                if (v != sample)
                    edges[std::size_t(n++)] = at(v) - at(sample);
            const double volume = edges[0].dot(edges[1].cross(edges[2]));
            if (volume == 0)
                continue;
            const std::array<double, 3> shares = {towards.dot(edges[1].cross(edges[2])) / volume,
                                                  edges[0].dot(towards.cross(edges[2])) / volume,
                                                  edges[0].dot(edges[1].cross(towards)) / volume};
            const double least = *std::min_element(shares.begin(), shares.end()) /
                                 (std::abs(shares[0]) + std::abs(shares[1]) + std::abs(shares[2]));
            if (least > most)
            {
                most = least;
                best = cell;
            }
        }
        return best;
    }

    /// -1: none.
    int find_pole(int sample, const Vector& towards) const
    {
        int best = -1;
        double farthest = 0;
        for (int k = at_.first[std::size_t(sample)]; k < at_.first[std::size_t(sample) + 1]; ++k)
        {
            const int cell = at_.cell[std::size_t(k)];
            if (!delaunay_.is_finite(cell))
                continue;
            const Vector offset = delaunay_.centres[std::size_t(cell)] - at(sample);
            const double distance = offset.norm();
            if (distance > farthest && offset.dot(towards) > pole_within * distance)
            {
                farthest = distance;
                best = cell;
            }
        }
        return best;
    }

    const Points& samples_;
    const Vectors& normals_;
    Triangulation delaunay_;
    CellsAtVertices at_;
    int without_; ///< Node of all outside the hull.
    std::vector<Side> labels_;
    double contradicted_ = 0;
};

/// Candidates on facets, finer than the disks that choose among them.
class FacetFiller
{
public:
    /// \param are_thinned whether of pieces much narrower than their disks some suffice: facets from a row of samples
    /// to a place far off lie side by side there, by the square of the samples together. \param most pieces [count].
    FacetFiller(const Points& samples, const std::vector<double>& spacings, const BlockSearch& search, bool are_thinned,
                std::size_t most)
        : samples_(samples), spacings_(spacings), search_(search), are_thinned_(are_thinned), most_(most)
    {
    }

    /// \returns false if there are too many pieces: then the candidates are of no use. \throws Cancelled.
    bool fill(const Point& a, const Point& b, const Point& c, const Progress& progress, double done)
    {
        const Vector across = (b - a).cross(c - a);
        normal_ = across.normalized();
        return fill(a, b, c, {across.norm(), 1, 0}, progress, done);
    }

    Points points;
    Vectors normals;
    std::vector<double> radii;
    std::size_t pieces = 0; ///< That were looked at [count].

private:
    /// Two or three halvings halve the sides, and a double no longer tells halves of its last bit from the whole.
    static constexpr int deepest = 120;
    /// Width of a piece below which not all are needed [radii of the disks]: 20 and more are left per disk.
    static constexpr double narrow = 0.3;
    static constexpr std::size_t pieces_per_report = 8192;

    struct Piece
    {
        double twice_area;
        double share; ///< Of pieces like it that are still there.
        int depth;
    };

    bool fill(const Point& a, const Point& b, const Point& c, Piece piece, const Progress& progress, double done)
    {
        const Point centre = (a + b + c) / 3;
        const auto nearest = std::size_t(search_.nearest(centre));
        const double distance = (centre - samples_[nearest]).norm();
        const double radius = std::max(disk * spacings_[nearest], disk_by_distance * distance);
        const std::array<double, 3> sides = {(b - c).norm(), (c - a).norm(), (a - b).norm()};
        const auto longest = std::max_element(sides.begin(), sides.end()) - sides.begin();
        const double length = sides[std::size_t(longest)];
        const bool is_small = length <= radius || piece.depth == deepest;
        const double least_radius = is_small ? radius : disk_by_distance * (distance - 2 * length / 3);
        const bool is_left_out = are_thinned_ && leave_out(piece, length, least_radius);
        if (is_small || is_left_out)
        {
            if (++pieces % pieces_per_report == 0)
                progress.report(done);
            if (pieces > most_)
                return false;
            if (is_left_out || distance < apart * spacings_[nearest])
                return true;
            points.push_back(centre);
            normals.push_back(normal_);
            radii.push_back(radius);
            return true;
        }
        const std::array<const Point*, 3> corners = {&a, &b, &c};
        const Point &tip = *corners[std::size_t(longest)], &from = *corners[std::size_t(longest + 1) % 3],
                    &to = *corners[std::size_t(longest + 2) % 3];
        const Point middle = (from + to) / 2;
        const Piece half{0.5 * piece.twice_area, piece.share, piece.depth + 1};
        return fill(tip, from, middle, half, progress, done) && fill(tip, middle, to, half, progress, done);
    }

    /// By chance, as few as its width asks for where disks have at least that radius.
    bool leave_out(Piece& piece, double length, double least_radius)
    {
        const double share = piece.twice_area / (narrow * least_radius * length);
        if (!(least_radius > 0) || share > 0.5 * piece.share)
            return false;
        const bool stays = scramble_to_unit(chances_++) * piece.share < share;
        piece.share = share;
        return !stays;
    }

    const Points& samples_;
    const std::vector<double>& spacings_;
    const BlockSearch& search_;
    bool are_thinned_;
    std::size_t most_;
    Vector normal_ = Vector::Zero(); ///< Of the facet.
    std::uint64_t chances_ = 0;
};

} // namespace

BareFaces fill_bare_faces(const Points& samples, const Vectors& normals, const BareFacesWanted& wanted, int threads,
                          const Progress& progress)
{
    const TetrahedronCut cut(samples, normals, threads, progress.part(0, 0.6, "Delaunay triangulation"));
    const BlockSearch search(samples, threads);
    std::vector<double> spacings(samples.size());
    parallel_for(samples.size(), threads, {},
                 [&](std::size_t i) { spacings[i] = measure_spacing_at(samples[i], search); });
    double area = 0, bare = 0;
    std::vector<Facet> facets;
    for (const Facet& facet : cut.list_boundary())
    {
        const auto [u, v, w] = facet;
        const Point &a = samples[std::size_t(u)], &b = samples[std::size_t(v)], &c = samples[std::size_t(w)];
        const double twice = (b - a).cross(c - a).norm();
        area += twice;
        const double usual = std::min({spacings[std::size_t(u)], spacings[std::size_t(v)], spacings[std::size_t(w)]});
        if (!(twice > 0) || std::max({(b - c).norm(), (c - a).norm(), (a - b).norm()}) < bare_side * usual)
            continue;
        bare += twice;
        facets.push_back(facet);
    }
    BareFaces result;
    result.contradicted = cut.contradicted();
    result.share = area > 0 ? bare / area : 0;
    result.are_wanted = result.share >= wanted.least_share && result.contradicted <= wanted.most_contradicted;
    if (!result.are_wanted)
        return result;
    const auto fill = [&](bool are_thinned, const Progress& filling)
    {
        FacetFiller filler(samples, spacings, search, are_thinned,
                           (are_thinned ? more_if_thinned : 1) *
                               std::min(most_pieces, most_pieces_per_sample * samples.size()));
        result.are_wanted = true;
        for (std::size_t i = 0; i < facets.size() && result.are_wanted; ++i)
        {
            const double done = double(i) / double(facets.size());
            filling.report(done);
            const auto [u, v, w] = facets[i];
            result.are_wanted =
                filler.fill(samples[std::size_t(u)], samples[std::size_t(v)], samples[std::size_t(w)], filling, done);
        }
        result.pieces += filler.pieces;
        if (!result.are_wanted)
            return;
        for (const int i : keep_apart(filler.points, filler.radii))
        {
            result.points.push_back(filler.points[std::size_t(i)]);
            result.normals.push_back(filler.normals[std::size_t(i)]);
        }
    };
    fill(false, progress.part(0.6, 0.8, "bare faces"));
    if (!result.are_wanted)
        fill(true, progress.part(0.8, 1, "bare faces"));
    return result;
}

std::optional<LabelledBareFaces> label_with_bare_faces(std::size_t points, double violated,
                                                       const std::function<SamplesOfFaces()>& list_samples,
                                                       const LabelWithin& label, PhaseTimes& times, int threads,
                                                       const Progress& progress)
{
    if (violated <= objecting || points > most_points)
        return {};
    try
    {
        auto [all, are_sheet] = list_samples();
        times.begin("bare faces");
        const BareFaces faces =
            fill_bare_faces(all.points, all.normals, {are_sheet ? more_than_lids : much, bearable}, threads, progress);
        if (!faces.are_wanted)
            return {};
        all.points.insert(all.points.end(), faces.points.begin(), faces.points.end());
        all.normals.insert(all.normals.end(), faces.normals.begin(), faces.normals.end());
        const double bearable_votes = clearly_fewer * violated;
        LabelledBalls labelled = label(all.points, all.normals, bearable_votes);
        if (labelled.violated_votes > bearable_votes)
            return {};
        return LabelledBareFaces{std::move(all.points), std::move(all.normals), std::move(labelled),
                                 int(faces.points.size())};
    }
    catch (const AlgorithmFailure&) // nothing is inside
    {
        return {};
    }
}

} // namespace recon
