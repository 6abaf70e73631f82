#include "crease_detection.h"

#include "face_fit.h"

#include <recon/disjoint_sets.h>
#include <recon/neighbours.h>
#include <recon/parallel.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>

namespace recon::pn
{

namespace
{

constexpr double room = 0.65;             ///< Between crease samples [spacings].
constexpr double longest_detour = 2.4;    ///< From one sample over its edge to the other [spacings].
constexpr double corner_volume = 0.3;     ///< Least of three normals: else their planes nearly share a line.
constexpr double along = 0.7;             ///< Least cosine of the angle between a line and its next sample.
constexpr double next_on_line = 4;        ///< Farthest it lies away [spacings].
constexpr int least_sharp = 3;            ///< Of the samples of a line so many must be sharp,
constexpr int safely_sharp = 12;          ///< but so many where hardly any are elsewhere,
constexpr double least_sharp_share = 0.4; ///< and this share of the line's.

/// A place on an edge or corner, and a sample of each face that meets there.
struct Place
{
    Point point;
    std::vector<int> around;
    double spacing; ///< Of the cloud here.
    bool is_sharp = false;

    bool is_corner() const { return around.size() > 2; }
};

/// Two samples on different faces.
struct Pair
{
    int i, j;
    double length;
};

/// Takes of places near each other those that are asked for first.
class Thinning
{
public:
    /// \param taken positions that are taken from the beginning.
    Thinning(const std::vector<Place>& proposed, const Points& taken) : proposed_(proposed)
    {
        for (const Place& p : proposed)
            positions_.push_back(p.point);
        is_taken_.assign(positions_.size(), 0);
        positions_.insert(positions_.end(), taken.begin(), taken.end());
        is_taken_.resize(positions_.size(), 1);
        search_ = std::make_unique<NeighbourSearch>(positions_);
    }
    bool is_free(std::size_t k)
    {
        search_->within(positions_[k], room * proposed_[k].spacing, near_);
        return std::none_of(near_.begin(), near_.end(), [&](int m) { return is_taken_[std::size_t(m)] != 0; });
    }
    void take(std::size_t k) { is_taken_[k] = 1; }

private:
    const std::vector<Place>& proposed_;
    Points positions_;
    std::vector<char> is_taken_;
    std::unique_ptr<NeighbourSearch> search_;
    std::vector<int> near_;
};

class CreaseFinder
{
public:
    CreaseFinder(const UsableSamples& usable, const std::vector<float>& spacing, double crease_angle, int threads)
        : usable_(usable), points_(usable.samples.points), normals_(usable.samples.normals), spacing_(spacing),
          same_(std::cos(crease_angle)), threads_(threads)
    {
    }

    std::vector<Place> find() const
    {
        const std::vector<Pair> pairs = where_sharp(near_pairs());
        std::vector<Place> proposed = corners_of(pairs);
        for (const Pair& pair : pairs)
            propose_edge(pair, proposed);
        std::vector<Place> places = on_lines(choose(proposed));
        close_corners(places);
        return places;
    }

private:
    const Point& point(int i) const { return points_[std::size_t(i)]; }
    const Vector& normal(int i) const { return normals_[std::size_t(i)]; }

    /// Shortest first.
    std::vector<Pair> near_pairs() const
    {
        constexpr int near = 16;
        constexpr std::size_t chunk = 1024;
        std::vector<std::vector<Pair>> found(points_.size() / chunk + 1);
        parallel_chunks(points_.size(), threads_, chunk, {},
                        [&](std::size_t begin, std::size_t end)
                        {
                            for (auto i = int(begin); i < int(end); ++i)
                                for (int m = 0; m < std::min(near, usable_.nearest.count); ++m)
                                {
                                    const int j = usable_.nearest.of(std::size_t(i))[m];
                                    if (i < j && normal(i).dot(normal(j)) < same_ && point(i) != point(j) &&
                                        !usable_.is_crease[std::size_t(i)] && !usable_.is_crease[std::size_t(j)])
                                        found[begin / chunk].push_back({i, j, (point(i) - point(j)).norm()});
                                }
                        });
        std::vector<Pair> pairs;
        for (const std::vector<Pair>& part : found)
            pairs.insert(pairs.end(), part.begin(), part.end());
        std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.length < b.length; });
        return pairs;
    }

    /// Without those that have none near that may be sharp: noisy normals make pairs everywhere.
    std::vector<Pair> where_sharp(std::vector<Pair> pairs) const
    {
        std::vector<char> is_paired(points_.size(), 0), may_be_sharp(points_.size(), 0), is_near(points_.size(), 0);
        for (const Pair& pair : pairs)
            is_paired[std::size_t(pair.i)] = is_paired[std::size_t(pair.j)] = 1;
        parallel_for(points_.size(), threads_, {},
                     [&](std::size_t i) { may_be_sharp[i] = is_paired[i] && may_end_sharply(usable_, i); });
        for (const Pair& pair : pairs)
            if (may_be_sharp[std::size_t(pair.i)] && may_be_sharp[std::size_t(pair.j)])
                for (const int end : {pair.i, pair.j})
                    for (int m = 0; m < usable_.nearest.count; ++m)
                        is_near[std::size_t(usable_.nearest.of(std::size_t(end))[m])] = 1;
        pairs.erase(std::remove_if(pairs.begin(), pairs.end(),
                                   [&](const Pair& pair)
                                   { return !is_near[std::size_t(pair.i)] && !is_near[std::size_t(pair.j)]; }),
                    pairs.end());
        return pairs;
    }

    Place place(const Point& x, std::vector<int> around) const
    {
        double sum = 0;
        for (int i : around)
            sum += double(spacing_[std::size_t(i)]);
        const double mean = sum / double(around.size());
        return {x, std::move(around), mean};
    }

    void propose_edge(const Pair& pair, std::vector<Place>& proposed) const
    {
        const Vector &a = normal(pair.i), &b = normal(pair.j);
        // The point of the planes' intersection that is nearest to the middle.
        const Point middle = 0.5 * (point(pair.i) + point(pair.j));
        const double da = a.dot(point(pair.i) - middle), db = b.dot(point(pair.j) - middle), c = a.dot(b),
                     d = 1 - c * c;
        if (d < 1e-6)
            return;
        const Point x = middle + ((da - c * db) / d) * a + ((db - c * da) / d) * b;
        // Farther away the two belong to different sheets, not to two sides of one crease.
        const double detour = (x - point(pair.i)).norm() + (x - point(pair.j)).norm();
        Place edge = place(x, {pair.i, pair.j});
        if ((x - middle).norm() <= pair.length && detour < longest_detour * edge.spacing)
            proposed.push_back(std::move(edge));
    }

    /// Where the planes of three samples meet; false if they nearly share a line.
    bool meet(int a, int b, int c, Point& x) const
    {
        Eigen::Matrix3d planes;
        planes << normal(a).transpose(), normal(b).transpose(), normal(c).transpose();
        if (std::abs(planes.determinant()) < corner_volume)
            return false;
        const Vector heights(0, normal(b).dot(point(b) - point(a)), normal(c).dot(point(c) - point(a)));
        x = point(a) + planes.inverse() * heights;
        return true;
    }

    /// Places where the planes of three near samples meet.
    std::vector<Place> corners_of(const std::vector<Pair>& pairs) const
    {
        std::vector<std::vector<int>> across(points_.size());
        for (const Pair& pair : pairs)
            across[std::size_t(pair.i)].push_back(pair.j);
        std::vector<Place> corners;
        for (const Pair& pair : pairs)
        {
            const std::vector<int>& of_i = across[std::size_t(pair.i)];
            for (int k : across[std::size_t(pair.j)])
            {
                Point x;
                if (std::find(of_i.begin(), of_i.end(), k) == of_i.end() || !meet(pair.i, pair.j, k, x))
                    continue;
                const Point &a = point(pair.i), &b = point(pair.j), &c = point(k);
                if ((x - (a + b + c) / 3).norm() <= std::max((a - c).norm(), (b - c).norm()))
                    corners.push_back(place(x, {pair.i, pair.j, k}));
            }
        }
        return corners;
    }

    /// Whether the faces of samples i and j end at x, as at an edge of the two: each lies on one side of the other, and
    /// no sample around has a normal between the two, as where a surface just bends.
    bool is_edge(int i, int j, const Point& x) const
    {
        const Vector &a = normal(i), &b = normal(j);
        const double side_of_i = (point(i) - x).dot(b), side_of_j = (point(j) - x).dot(a);
        if (side_of_i * side_of_j <= 0)
            return false;
        constexpr int looked_at = 12;
        constexpr double between = 0.75;                  // of the angle from one face to the other, seen from either
        constexpr double same_face = 0.9, in_plane = 0.3; // cosine, sine
        constexpr double beyond = 0.2;                    // sine of the angle to the plane of the other
        const double least = std::cos(between * std::acos(std::clamp(a.dot(b), -1.0, 1.0)));
        const double nearby = std::max((point(i) - x).norm(), (point(j) - x).norm());
        int near[looked_at];
        double squared[looked_at];
        double reach = 1.5 * nearby;
        const int found = usable_.search->nearest(x, looked_at, near, squared, reach);
        const auto goes_on = [&](const Vector& n, const Vector& d, const Vector& own, const Vector& other, double side)
        {
            return n.dot(own) > same_face && std::abs(d.dot(own)) < in_plane * d.norm() &&
                   d.dot(other) * (side > 0 ? 1 : -1) < -beyond * d.norm();
        };
        return std::none_of(near, near + found,
                            [&](int m)
                            {
                                const Vector& n = normal(m);
                                const Vector d = point(m) - x;
                                if (d.norm() >= 1.5 * nearby)
                                    return false;
                                if (n.dot(a) > least && n.dot(b) > least)
                                    return true;
                                return d.norm() < nearby &&
                                       (goes_on(n, d, a, b, side_of_i) || goes_on(n, d, b, a, side_of_j));
                            });
    }

    /// Whether each two of these faces meet at x in an edge, or (`sharply`) end there sharply.
    bool all_meet(const Place& at, bool sharply) const
    {
        for (std::size_t p = 0; p < at.around.size(); ++p)
            for (std::size_t q = 0; q < p; ++q)
            {
                const int i = at.around[p], j = at.around[q];
                if (sharply ? !ends_sharply(usable_, std::size_t(i), std::size_t(j), at.point, same_)
                            : !is_edge(i, j, at.point))
                    return false;
            }
        return true;
    }

    /// Of places near each other the first, but sharp ones before others.
    std::vector<Place> choose(const std::vector<Place>& proposed) const
    {
        Points own;
        for (std::size_t i = 0; i < points_.size(); ++i)
            if (usable_.is_crease[i])
                own.push_back(points_[i]);
        Thinning thinning(proposed, own);
        std::vector<Place> chosen;
        std::vector<std::size_t> doubtful;
        const auto take = [&](std::size_t k, bool is_sharp)
        {
            thinning.take(k);
            chosen.push_back(proposed[k]);
            chosen.back().is_sharp = is_sharp;
        };
        for (std::size_t k = 0; k < proposed.size(); ++k)
        {
            if (!thinning.is_free(k) || !all_meet(proposed[k], false))
                continue;
            if (all_meet(proposed[k], true))
                take(k, true);
            else
                doubtful.push_back(k);
        }
        if (int(chosen.size()) < least_sharp)
            return {};
        for (std::size_t k : doubtful)
            if (thinning.is_free(k))
                take(k, false);
        return chosen;
    }

    /// Whether a line along which two of the faces meet leads from here in this direction.
    bool leads(const Place& from, const Vector& unit) const
    {
        for (std::size_t p = 0; p < from.around.size(); ++p)
            for (std::size_t q = 0; q < p; ++q)
            {
                const Vector line = normal(from.around[p]).cross(normal(from.around[q]));
                if (std::abs(line.dot(unit)) > along * line.norm())
                    return true;
            }
        return false;
    }

    /// Those on lines that are sharp in enough places: one alone is chance, and between sharp ones those are believed
    /// too whose faces show too few samples (hysteresis, as Canny's).
    std::vector<Place> on_lines(const std::vector<Place>& places) const
    {
        Points positions;
        for (const Place& p : places)
            positions.push_back(p.point);
        const NeighbourSearch search(positions);
        constexpr int most = 12;
        const int k = std::min(most, int(places.size()));
        DisjointSets lines(places.size());
        for (std::size_t i = 0; i < places.size(); ++i)
        {
            int near[most];
            double squared[most];
            const int found = search.nearest(positions[i], k, near, squared);
            for (int m = 0; m < found; ++m)
            {
                const auto j = std::size_t(near[m]);
                const double length = std::sqrt(squared[m]);
                if (!(length > 0) || length > next_on_line * places[i].spacing)
                    continue;
                const Vector unit = (positions[j] - positions[i]) / length;
                if (leads(places[i], unit) && leads(places[j], unit))
                    lines.join(int(i), int(j));
            }
        }
        std::vector<int> all(places.size(), 0), sharp(places.size(), 0);
        for (std::size_t i = 0; i < places.size(); ++i)
        {
            const auto line = std::size_t(lines.find(int(i)));
            ++all[line];
            sharp[line] += places[i].is_sharp;
        }
        // Where few of all places are sharp a short line of them is chance as well.
        const int sharp_in_all = std::accumulate(sharp.begin(), sharp.end(), 0);
        const int least = std::clamp(int(places.size()) / std::max(sharp_in_all, 1), least_sharp, safely_sharp);
        std::vector<Place> kept;
        for (std::size_t i = 0; i < places.size(); ++i)
            if (const auto line = std::size_t(lines.find(int(i)));
                sharp[line] >= least && sharp[line] >= least_sharp_share * all[line])
                kept.push_back(places[i]);
        return kept;
    }

    /// Finds the corner to which edges at two places lead that share a face. \returns whether there is one.
    bool corner_of(const Place& first, const Place& second, Place& corner) const
    {
        constexpr double same_face = 0.9, in_plane = 0.2; // cosine, sine
        const Vector d = second.point - first.point;
        for (std::size_t f = 0; f < 2; ++f)
            for (std::size_t g = 0; g < 2; ++g)
            {
                const int a = first.around[f], b = first.around[1 - f], a2 = second.around[g], c = second.around[1 - g];
                Point x;
                if (normal(a).dot(normal(a2)) < same_face || normal(b).dot(normal(c)) > same_ ||
                    std::abs(normal(a).dot(d)) > in_plane * d.norm() || !meet(a, b, c, x))
                    continue;
                corner = place(x, {a, b, c});
                const double reach = 2.3 * corner.spacing;
                if ((x - first.point).norm() <= reach && (x - second.point).norm() <= reach &&
                    all_meet(corner, false) && all_meet(corner, true))
                    return true;
            }
        return false;
    }

    /// Adds corners to which edges lead, where the samples of one face are too far from those of another for
    /// corners_of(). Places on edges very near to them are given up.
    void close_corners(std::vector<Place>& places) const
    {
        Points positions, taken;
        for (const Place& p : places)
        {
            positions.push_back(p.point);
            if (p.is_corner())
                taken.push_back(p.point);
        }
        const NeighbourSearch search(positions);
        std::vector<Place> proposed;
        std::vector<int> near;
        for (std::size_t i = 0; i < places.size(); ++i)
        {
            search.within(positions[i], next_on_line * places[i].spacing, near);
            std::sort(near.begin(), near.end());
            Place corner;
            for (int m : near)
                if (const auto j = std::size_t(m); j > i && !places[i].is_corner() && !places[j].is_corner() &&
                                                   corner_of(places[i], places[j], corner))
                    proposed.push_back(corner);
        }
        constexpr double crowded = 0.4; // [spacings]
        Thinning thinning(proposed, taken);
        std::vector<Place> added;
        std::vector<char> is_given_up(places.size(), 0);
        for (std::size_t k = 0; k < proposed.size(); ++k)
        {
            if (!thinning.is_free(k))
                continue;
            thinning.take(k);
            added.push_back(proposed[k]);
            search.within(proposed[k].point, crowded * proposed[k].spacing, near);
            for (int m : near)
                is_given_up[std::size_t(m)] = !places[std::size_t(m)].is_corner();
        }
        for (std::size_t i = 0; i < places.size(); ++i)
            if (!is_given_up[i])
                added.push_back(std::move(places[i]));
        places = std::move(added);
    }

    const UsableSamples& usable_;
    const Points& points_;
    const Vectors& normals_;
    const std::vector<float>& spacing_;
    const double same_;
    const int threads_;
};

} // namespace

AddedSamples detect_creases(const UsableSamples& usable, const std::vector<float>& spacing, double crease_angle,
                            int threads)
{
    AddedSamples creases;
    for (const Place& place : CreaseFinder(usable, spacing, crease_angle, threads).find())
        for (int i : place.around)
        {
            creases.samples.points.push_back(place.point);
            creases.samples.normals.push_back(usable.samples.normals[std::size_t(i)]);
            // One's own side counts double.
            const int other = place.around[0] == i ? place.around[1] : place.around[0];
            creases.parents.push_back({i, i, other});
        }
    return creases;
}

} // namespace recon::pn
