#include "hole_filling.h"

#include "sparse_set.h"

#include <recon/parallel.h>
#include <recon/search/neighbours.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

namespace recon::pn
{
namespace
{

/// Points put into a hole keep this distance from each other and from the samples [spacings].
constexpr double apart = 0.75;
/// Circles this wide are holes [spacings]: random samples leave narrower ones everywhere, and the steps close those.
constexpr double least_room = 2;
/// Wider holes than this stay open [hole radii]: a ragged rim lies farther back than the hole that was cut.
constexpr double most_room = 1.25;
/// What the nearest sample lies above or below [sine] is no hole: there the coarse surface misses the fine one.
constexpr double steepest = 0.6;
/// From one thinning to the next: the steps close some 2.5 spacings, on curved surfaces two.
constexpr double coarser = 1.4142135623730951;
/// Share of the samples around a hole that must end the surface there; those behind a ragged rim have closed fans.
constexpr double least_open = 0.55;
constexpr double open_fan = 2.0943951; ///< Gap of a fan that ends the surface [radians], except where holes are small:
constexpr double small = 3;            ///< there even fans on their rims have narrower ones [spacings].
constexpr double least_of_distance = 0.6; ///< Room of a hole that was not filled by finer thinnings.
constexpr int probe_steps = 3;            ///< They show where holes are, at little cost.
constexpr double finest = 1.0 / 64;       ///< Points in a hole, in distances of the thinned samples around it.
constexpr double finer = 0.6;             ///< Refined places, of which those in holes are thinned out [spacings].
constexpr double most_at_once = 4e6;      ///< Places on a coarse surface, beyond which holes are filled less densely.
constexpr std::size_t samples_at_once = 1024; ///< Between two reports of progress.

/// Open balls in classes of like radii, so that the nearest centre of a class mostly tells: within the largest radius
/// of a point there are thousands of centres where holes are large, and nobody wants a list of them for every point.
class UnionOfBalls
{
public:
    /// \pre radii are positive.
    UnionOfBalls(const Points& centres, const std::vector<double>& radii)
    {
        std::map<int, Class> classes;
        for (std::size_t k = 0; k < centres.size(); ++k)
        {
            Class& own = classes[int(std::floor(std::log(radii[k]) / std::log(growth)))];
            own.centres.push_back(centres[k]);
            own.radii.push_back(radii[k]);
        }
        for (auto& [size, balls] : classes)
            classes_.push_back(std::make_unique<Class>(std::move(balls)));
        for (const std::unique_ptr<Class>& balls : classes_)
        {
            balls->search = std::make_unique<NeighbourSearch>(balls->centres);
            const auto [least, most] = std::minmax_element(balls->radii.begin(), balls->radii.end());
            balls->least = *least;
            balls->most = *most;
        }
    }

    bool hold(const Point& p) const
    {
        return std::any_of(classes_.begin(), classes_.end(),
                           [&](const std::unique_ptr<Class>& balls) { return balls->hold(p); });
    }

private:
    static constexpr double growth = 1.25; ///< From the least to the largest radius of a class.

    struct Class
    {
        Points centres;
        std::vector<double> radii;
        double least = 0, most = 0; ///< Of the radii.
        std::unique_ptr<NeighbourSearch> search;

        bool hold(const Point& p) const
        {
            const auto distance = [&](int k) { return (p - centres[std::size_t(k)]).norm(); };
            const double nearest = distance(search->nearest(p));
            if (nearest < least || nearest >= most)
                return nearest < least;
            thread_local std::vector<int> near;
            search->within(p, most, near);
            return std::any_of(near.begin(), near.end(), [&](int k) { return distance(k) < radii[std::size_t(k)]; });
        }
    };
    std::vector<std::unique_ptr<Class>> classes_; // searches refer to the centres
};

/// Points each of which keeps a distance of its own: two of them about the lesser of theirs.
class SparseSetOfSizes
{
public:
    bool has_near(const Point& p, double distance) const
    {
        return std::any_of(sets_.begin(), sets_.end(),
                           [&](const auto& set) { return set.second.has_near(p, distance); });
    }
    void add(const Point& p, double distance)
    {
        const int size = int(std::ceil(std::log(distance) / std::log(growth)));
        sets_.try_emplace(size, std::pow(growth, size)).first->second.add(p);
    }

private:
    static constexpr double growth = 1.25;
    std::map<int, SparseSet> sets_; ///< Of all whose distance is this power or a little less.
};

class HoleFiller
{
public:
    HoleFiller(const UsableSamples& usable, const InitialFans& fans, const std::vector<float>& spacing,
               double boundary_angle, double hole_radius, int threads)
        : usable_(usable), fans_(fans), hole_radius_(hole_radius), threads_(threads), samples_(usable.samples),
          spacing_(spacing.begin(), spacing.end())
    {
        for (int i = 0; i < int(usable.input.size()); ++i)
            if (fans.widest_gap[std::size_t(i)] > boundary_angle && !usable.is_crease[std::size_t(i)] &&
                fans.radius[std::size_t(i)] > 0 && spacing[std::size_t(i)] > 0)
                rims_.push_back(i);
        search_ = std::make_unique<NeighbourSearch>(samples_.points);
    }

    FilledHoles fill(const RefineCoarse& refine, const Progress& progress)
    {
        filled_.has_rims = !rims_.empty();
        const std::vector<double> distances = thinning_distances();
        if (!distances.empty())
        {
            find_distances_to_rims(progress.part(0, 0.05));
            find_too_wide(refine, progress.part(0.05, 0.15));
        }
        for (std::size_t k = 0; k < distances.size(); ++k)
        {
            const auto at = [&](std::size_t level) { return 0.15 + 0.85 * double(level) / double(distances.size()); };
            fill_level(distances[k], refine, progress.part(at(k), at(k + 1)));
        }
        return std::move(filled_);
    }

private:
    /// Samples as far apart as the hole is wide.
    struct Coarse
    {
        OrientedSamples samples;
        std::vector<int> origin; ///< Samples.
        std::vector<double> spacing;
    };

    /// A place on the coarse surface.
    struct Place
    {
        int nearest;    ///< Sample.
        double room;    ///< From there.
        double spacing; ///< Usual here.
        bool is_hole;
    };

    int input_count() const { return int(usable_.input.size()); }
    const Point& point(int i) const { return samples_.points[std::size_t(i)]; }

    /// Ascending. A hole is filled with the first that spans it, from samples as near to it as can be.
    std::vector<double> thinning_distances() const
    {
        double least = hole_radius_;
        for (int i : rims_)
            least = std::min(least, spacing_[std::size_t(i)]);
        std::vector<double> distances;
        constexpr std::size_t most = 40;
        for (double d = hole_radius_; d > 1.1 * least && distances.size() < most; d /= coarser)
            distances.push_back(d);
        std::reverse(distances.begin(), distances.end());
        return distances;
    }

    void find_distances_to_rims(const Progress& progress)
    {
        Points rims;
        for (int i : rims_)
            rims.push_back(point(i));
        const NeighbourSearch search(rims);
        to_rim_.resize(samples_.points.size());
        parallel_for(
            to_rim_.size(), threads_, progress,
            [&](std::size_t i)
            { to_rim_[i] = (point(int(i)) - rims[std::size_t(search.nearest(point(int(i))))]).norm(); },
            samples_at_once);
    }

    /// Before any is begun to be filled from its rim: thinned less than they are wide, they look like several.
    void find_too_wide(const RefineCoarse& refine, const Progress& progress)
    {
        Points centres;
        std::vector<double> radii;
        constexpr std::array<double, 2> wider = {2, 4}; // [hole radii]
        for (std::size_t k = 0; k < wider.size(); ++k)
        {
            const double distance = wider[k] * hole_radius_;
            const Coarse coarse = thin_around_rims(distance);
            if (coarse.samples.points.size() < 3)
                continue;
            const Progress part = progress.part(double(k) / wider.size(), double(k + 1) / wider.size());
            const Refined refined = refine(coarse.samples, probe_steps + 1, part.part(0, 0.7));
            const std::vector<Place> places = look_at(refined, coarse, 0, part.part(0.7, 1));
            int count = 0;
            for (const Hole& hole : collect_holes(refined, places))
            {
                if (hole.room <= most_room * hole_radius_ || !is_surrounded_by_rim(hole, refined))
                    continue;
                ++count;
                for (std::size_t place : hole.places)
                {
                    centres.push_back(refined.points[place]);
                    radii.push_back(1.1 * places[place].room);
                }
            }
            filled_.too_wide = std::max(filled_.too_wide, count);
        }
        too_wide_ = std::make_unique<UnionOfBalls>(centres, radii);
    }

    void fill_level(double distance, const RefineCoarse& refine, const Progress& progress)
    {
        const auto steps_for = [&](double spacing)
        { return std::clamp(int(std::ceil(std::log(distance / (finer * spacing)) / std::log(1.7))) + 1, 1, 12); };
        Coarse coarse = thin_around_rims(distance);
        if (coarse.samples.points.size() < 3)
            return;
        Refined refined = refine(coarse.samples, probe_steps, progress.part(0, 0.2));
        std::vector<Place> places = look_at(refined, coarse, 0, progress.part(0.2, 0.3));
        Points holes;
        double spacing = distance;
        for (std::size_t k = 0; k < places.size(); ++k)
            if (places[k].is_hole)
            {
                holes.push_back(refined.points[k]);
                spacing = std::min(spacing, places[k].spacing);
            }
        if (holes.empty())
            return;
        coarse = keep_near(coarse, holes, 5 * distance);
        if (coarse.samples.points.size() < 3)
            return;
        spacing = std::max({spacing, finest * distance,
                            distance / finer * std::sqrt(double(coarse.samples.points.size()) / most_at_once)});
        refined = refine(coarse.samples, steps_for(spacing), progress.part(0.3, 0.7));
        places = look_at(refined, coarse, spacing, progress.part(0.7, 0.8));
        keep_in_holes(refined, coarse, places, distance);
        search_ = std::make_unique<NeighbourSearch>(samples_.points);
        progress.report(1);
    }

    Coarse thin_around_rims(double distance) const
    {
        SparseSet thinned(distance);
        Coarse coarse;
        const auto offer = [&](int i)
        {
            // Samples farther apart than this have no holes of that size.
            if (spacing_[std::size_t(i)] > 1.5 * distance || thinned.has_near(point(i)))
                return;
            thinned.add(point(i));
            add(coarse, i);
        };
        for (int i : rims_) // first: they say how the surface enters the hole
            offer(i);
        for (int i = 0; i < int(samples_.points.size()); ++i)
            if (to_rim_[std::size_t(i)] < 3 * distance)
                offer(i);
        return coarse;
    }

    void add(Coarse& coarse, int i) const
    {
        coarse.samples.points.push_back(point(i));
        coarse.samples.normals.push_back(samples_.normals[std::size_t(i)]);
        coarse.origin.push_back(i);
        coarse.spacing.push_back(spacing_[std::size_t(i)]);
    }

    Coarse keep_near(const Coarse& coarse, const Points& places, double reach) const
    {
        const NeighbourSearch search(places);
        Coarse kept;
        for (int i : coarse.origin)
            if ((point(i) - places[std::size_t(search.nearest(point(i)))]).norm() < reach)
                add(kept, i);
        return kept;
    }

    /// The spacing of a place is that of the samples which the surface comes from there, not of the nearest alone:
    /// beside a dense patch a sparse cloud has no holes. \param least spacing.
    std::vector<Place> look_at(const Refined& refined, const Coarse& coarse, double least,
                               const Progress& progress) const
    {
        std::vector<Place> places(refined.points.size());
        for (std::size_t k = 0; k < places.size(); ++k)
        {
            places[k].spacing = 0;
            for (int parent : refined.parents[k])
            {
                const auto p = std::size_t(parent), n = coarse.origin.size();
                places[k].spacing += (p < n ? coarse.spacing[p] : places[p - n].spacing) / 3;
            }
        }
        parallel_for(
            places.size(), threads_, progress,
            [&](std::size_t k)
            {
                Place& place = places[k];
                place.nearest = search_->nearest(refined.points[k]);
                const Vector to_nearest = point(place.nearest) - refined.points[k];
                place.room = to_nearest.norm();
                place.spacing = std::max({place.spacing, spacing_[std::size_t(place.nearest)], least});
                place.is_hole = place.room > least_room * place.spacing &&
                                std::abs(to_nearest.dot(refined.normals[k])) < steepest * place.room;
            },
            samples_at_once);
        return places;
    }

    /// Places that are near to each other and in holes.
    struct Hole
    {
        double room = 0, spacing = 0;      ///< Of the place that has most room.
        std::map<int, std::size_t> widest; ///< Per sample around it that place of its own which has most room.
        std::vector<std::size_t> places;
    };

    std::vector<Hole> collect_holes(const Refined& refined, const std::vector<Place>& places) const
    {
        std::vector<std::size_t> found;
        Points points;
        for (std::size_t k = 0; k < places.size(); ++k)
            if (places[k].is_hole)
            {
                found.push_back(k);
                points.push_back(refined.points[k]);
            }
        if (found.empty())
            return {};
        const NeighbourSearch search(points);
        std::vector<char> is_taken(found.size(), 0);
        std::vector<int> near, front;
        std::vector<Hole> holes;
        for (std::size_t first = 0; first < found.size(); ++first)
        {
            if (std::exchange(is_taken[first], char(1)))
                continue;
            Hole& hole = holes.emplace_back();
            front = {int(first)};
            while (!front.empty())
            {
                const auto k = std::size_t(front.back());
                front.pop_back();
                const Place& place = places[found[k]];
                hole.places.push_back(found[k]);
                if (place.room > hole.room)
                {
                    hole.room = place.room;
                    hole.spacing = place.spacing;
                }
                std::size_t& widest = hole.widest.try_emplace(place.nearest, found[k]).first->second;
                if (place.room > places[widest].room)
                    widest = found[k];
                search.within(points[k], 1.5 * place.spacing, near);
                for (int j : near)
                    if (!std::exchange(is_taken[std::size_t(j)], char(1)))
                        front.push_back(j);
            }
        }
        return holes;
    }

    /// Whether most samples around end the surface towards the hole. Else thinned samples of two limbs were joined.
    /// Samples put into holes count for neither: of holes that finer levels have begun to fill they are the rim.
    bool is_surrounded_by_rim(const Hole& hole, const Refined& refined) const
    {
        const bool is_small = hole.room < small * hole.spacing; // of those even rims see less than such a gap
        int open = 0, all = 0;
        for (const auto& [sample, place] : hole.widest)
            if (sample < input_count())
            {
                const Vector d = refined.points[place] - point(sample);
                const auto i = std::size_t(sample);
                ++all;
                open += (is_small || fans_.widest_gap[i] > open_fan) &&
                        std::abs(d.dot(samples_.normals[i])) < steepest * d.norm();
            }
        return double(open) >= least_open * double(all);
    }

    /// Places in holes that are to be filled. \param distance of the thinned samples.
    std::vector<std::size_t> centres_of_holes(const Refined& refined, const std::vector<Place>& places, double distance)
    {
        std::vector<std::size_t> centres;
        for (const Hole& hole : collect_holes(refined, places))
        {
            if (hole.room < least_of_distance * distance && hole.widest.begin()->first < input_count())
                continue;
            if (!is_surrounded_by_rim(hole, refined))
                continue;
            if (hole.room <= most_room * hole_radius_)
                centres.insert(centres.end(), hole.places.begin(), hole.places.end());
        }
        return centres;
    }

    void keep_in_holes(const Refined& refined, const Coarse& coarse, const std::vector<Place>& places, double distance)
    {
        // What is filled is the union of large empty balls: the usual unevenness of samples is left to refinement.
        Points centres;
        std::vector<double> radii;
        for (std::size_t k : centres_of_holes(refined, places, distance))
        {
            centres.push_back(refined.points[k]);
            radii.push_back(1.1 * places[k].room);
        }
        const UnionOfBalls holes(centres, radii);

        SparseSetOfSizes taken;
        const std::size_t coarse_count = coarse.origin.size();
        std::vector<int> sample(refined.points.size(), -1);
        for (std::size_t k = 0; k < refined.points.size(); ++k)
        {
            const Point& p = refined.points[k];
            const double free = apart * places[k].spacing;
            std::array<int, 3> parents;
            for (std::size_t m = 0; m < 3; ++m)
            {
                const auto parent = std::size_t(refined.parents[k][m]);
                parents[m] = parent < coarse_count ? coarse.origin[parent] : sample[parent - coarse_count];
            }
            const auto is_frozen = [&](int i) { return i < input_count() && usable_.is_frozen[std::size_t(i)]; };
            if (places[k].room <= free || taken.has_near(p, free) ||
                std::all_of(parents.begin(), parents.end(), is_frozen) || !holes.hold(p) || too_wide_->hold(p))
            {
                sample[k] = parents[0]; // stands in for it among the parents of others
                continue;
            }
            sample[k] = int(samples_.points.size());
            filled_.added.samples.points.push_back(p);
            filled_.added.samples.normals.push_back(refined.normals[k]);
            filled_.added.parents.push_back(parents);
            samples_.points.push_back(p);
            samples_.normals.push_back(refined.normals[k]);
            spacing_.push_back(places[k].spacing);
            to_rim_.push_back(0);
            taken.add(p, free);
        }
    }

    const UsableSamples& usable_;
    const InitialFans& fans_;
    const double hole_radius_;
    const int threads_;
    OrientedSamples samples_; ///< Usable ones, then those put in.
    std::vector<double> spacing_, to_rim_;
    std::vector<int> rims_;
    std::unique_ptr<NeighbourSearch> search_; ///< Of the samples.
    std::unique_ptr<UnionOfBalls> too_wide_;
    FilledHoles filled_;
};

} // namespace

FilledHoles fill_holes(const UsableSamples& usable, const InitialFans& fans, const std::vector<float>& spacing,
                       double boundary_angle, double hole_radius, const RefineCoarse& refine, int threads,
                       const Progress& progress)
{
    return HoleFiller(usable, fans, spacing, boundary_angle, hole_radius, threads).fill(refine, progress);
}

} // namespace recon::pn
