#include "crease_detection.h"

#include "crease_corners.h"
#include "face_fit.h"

#include <recon/disjoint_sets.h>
#include <recon/parallel.h>
#include <recon/search/neighbours.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace recon::pn
{

namespace
{

constexpr double longest_detour = 2.4;    ///< From one sample over its edge to the other [spacings].
constexpr double along = 0.7;             ///< Least cosine of the angle between a line and its next sample.
constexpr double next_on_line = 4;        ///< Farthest it lies away [spacings].
constexpr int least_sharp = 3;            ///< Of the samples of a line so many must be sharp,
constexpr int safely_sharp = 12;          ///< but so many where hardly any are elsewhere,
constexpr double least_sharp_share = 0.4; ///< and this share of the line's.

/// Two samples on different faces.
struct Pair
{
    int i, j;
    double length;
};

class CreaseFinder
{
public:
    CreaseFinder(const UsableSamples& usable, const std::vector<float>& spacing, double crease_angle, int threads)
        : usable_(usable), points_(usable.samples.points), faces_(usable, spacing, std::cos(crease_angle)),
          threads_(threads)
    {
    }

    std::vector<CreasePlace> find(const Progress& progress) const
    {
        const std::vector<Pair> pairs = where_sharp(near_pairs(progress.part(0, 0.15)), progress.part(0.15, 0.3));
        std::vector<CreasePlace> proposed = corners_of(pairs);
        for (const Pair& pair : pairs)
            propose_edge(pair, proposed);
        progress.report(0.4);
        std::vector<CreasePlace> places = on_lines(choose(proposed, progress.part(0.4, 0.8)));
        progress.report(0.9);
        close_corners(faces_, places);
        progress.report(1);
        return places;
    }

private:
    /// Shortest first.
    std::vector<Pair> near_pairs(const Progress& progress) const
    {
        constexpr int near = 16;
        std::vector<Pair> pairs = parallel_collect<Pair>(
            points_.size(), threads_, progress,
            [&](std::size_t point, std::vector<Pair>& found)
            {
                const int i = int(point);
                for (int m = 0; m < std::min(near, usable_.nearest.count); ++m)
                {
                    const int j = usable_.nearest.of(point)[m];
                    if (i < j && faces_.differ(i, j) && faces_.point(i) != faces_.point(j) &&
                        !usable_.is_crease[point] && !usable_.is_crease[std::size_t(j)])
                        found.push_back({i, j, (faces_.point(i) - faces_.point(j)).norm()});
                }
            },
            1024);
        std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.length < b.length; });
        return pairs;
    }

    /// Without those that have none near that may be sharp: noisy normals make pairs everywhere.
    std::vector<Pair> where_sharp(std::vector<Pair> pairs, const Progress& progress) const
    {
        std::vector<char> is_paired(points_.size(), 0), may_be_sharp(points_.size(), 0), is_near(points_.size(), 0);
        for (const Pair& pair : pairs)
            is_paired[std::size_t(pair.i)] = is_paired[std::size_t(pair.j)] = 1;
        parallel_for(points_.size(), threads_, progress,
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

    void propose_edge(const Pair& pair, std::vector<CreasePlace>& proposed) const
    {
        const Vector &a = faces_.normal(pair.i), &b = faces_.normal(pair.j);
        // The point of the planes' intersection that is nearest to the middle.
        const Point middle = 0.5 * (faces_.point(pair.i) + faces_.point(pair.j));
        const double da = a.dot(faces_.point(pair.i) - middle), db = b.dot(faces_.point(pair.j) - middle), c = a.dot(b),
                     d = 1 - c * c;
        if (d < 1e-6)
            return;
        const Point x = middle + ((da - c * db) / d) * a + ((db - c * da) / d) * b;
        // Farther away the two belong to different sheets, not to two sides of one crease.
        const double detour = (x - faces_.point(pair.i)).norm() + (x - faces_.point(pair.j)).norm();
        CreasePlace edge = faces_.place(x, {pair.i, pair.j});
        if ((x - middle).norm() <= pair.length && detour < longest_detour * edge.spacing)
            proposed.push_back(std::move(edge));
    }

    /// Places where the planes of three near samples meet.
    std::vector<CreasePlace> corners_of(const std::vector<Pair>& pairs) const
    {
        std::vector<std::vector<int>> across(points_.size());
        for (const Pair& pair : pairs)
            across[std::size_t(pair.i)].push_back(pair.j);
        std::vector<CreasePlace> corners;
        for (const Pair& pair : pairs)
        {
            const std::vector<int>& of_i = across[std::size_t(pair.i)];
            for (int k : across[std::size_t(pair.j)])
            {
                Point x;
                if (std::find(of_i.begin(), of_i.end(), k) == of_i.end() || !faces_.meet(pair.i, pair.j, k, x))
                    continue;
                const Point &a = faces_.point(pair.i), &b = faces_.point(pair.j), &c = faces_.point(k);
                if ((x - (a + b + c) / 3).norm() <= std::max((a - c).norm(), (b - c).norm()))
                    corners.push_back(faces_.place(x, {pair.i, pair.j, k}));
            }
        }
        return corners;
    }

    /// Of places near each other the first, but sharp ones before others.
    std::vector<CreasePlace> choose(const std::vector<CreasePlace>& proposed, const Progress& progress) const
    {
        Points own;
        for (std::size_t i = 0; i < points_.size(); ++i)
            if (usable_.is_crease[i])
                own.push_back(points_[i]);
        Thinning thinning(proposed, own);
        std::vector<CreasePlace> chosen;
        std::vector<std::size_t> doubtful;
        const auto take = [&](std::size_t k, bool is_sharp)
        {
            thinning.take(k);
            chosen.push_back(proposed[k]);
            chosen.back().is_sharp = is_sharp;
        };
        for (std::size_t k = 0; k < proposed.size(); ++k)
        {
            if (k % 4096 == 0)
                progress.report(double(k) / double(proposed.size()));
            if (!thinning.is_free(k) || !faces_.are_edges(proposed[k]))
                continue;
            if (faces_.are_sharp(proposed[k]))
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
    bool leads(const CreasePlace& from, const Vector& unit) const
    {
        for (std::size_t p = 0; p < from.around.size(); ++p)
            for (std::size_t q = 0; q < p; ++q)
            {
                const Vector line = faces_.normal(from.around[p]).cross(faces_.normal(from.around[q]));
                if (std::abs(line.dot(unit)) > along * line.norm())
                    return true;
            }
        return false;
    }

    /// Those on lines that are sharp in enough places: one alone is chance, and between sharp ones those are believed
    /// too whose faces show too few samples (hysteresis, as Canny's).
    std::vector<CreasePlace> on_lines(const std::vector<CreasePlace>& places) const
    {
        const Points positions = positions_of(places);
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
        std::vector<CreasePlace> kept;
        for (std::size_t i = 0; i < places.size(); ++i)
            if (const auto line = std::size_t(lines.find(int(i)));
                sharp[line] >= least && sharp[line] >= least_sharp_share * all[line])
                kept.push_back(places[i]);
        return kept;
    }

    const UsableSamples& usable_;
    const Points& points_;
    const Faces faces_;
    const int threads_;
};

} // namespace

AddedSamples detect_creases(const UsableSamples& usable, const std::vector<float>& spacing, double crease_angle,
                            int threads, const Progress& progress)
{
    const std::vector<CreasePlace> places = CreaseFinder(usable, spacing, crease_angle, threads).find(progress);
    AddedSamples creases;
    for (const int k : sort_spatially(positions_of(places)))
    {
        const CreasePlace& place = places[std::size_t(k)];
        if (std::all_of(place.around.begin(), place.around.end(),
                        [&](int i) { return usable.is_frozen[std::size_t(i)] != 0; }))
            continue;
        for (int i : place.around)
        {
            creases.samples.points.push_back(place.point);
            creases.samples.normals.push_back(usable.samples.normals[std::size_t(i)]);
            // One's own side counts double.
            const int other = place.around[0] == i ? place.around[1] : place.around[0];
            creases.parents.push_back({i, i, other});
        }
    }
    return creases;
}

} // namespace recon::pn
