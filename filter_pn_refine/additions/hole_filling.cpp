#include "hole_filling.h"

#include "sparse_set.h"

#include <recon/median.h>
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
constexpr double apart = 0.6;
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

class HoleFiller
{
public:
    HoleFiller(const UsableSamples& usable, const InitialFans& fans, double boundary_angle, double hole_radius,
               int threads)
        : usable_(usable), fans_(fans), hole_radius_(hole_radius), threads_(threads)
    {
        std::vector<double> spacings;
        for (int i = 0; i < int(usable.input.size()); ++i)
            if (fans.widest_gap[std::size_t(i)] > boundary_angle && !usable.is_crease[std::size_t(i)] && spacing(i) > 0)
            {
                rims_.push_back(i);
                spacings.push_back(spacing(i));
            }
        usual_ = median(std::move(spacings));
    }

    AddedSamples fill(const RefineCoarse& refine, const Progress& progress) const
    {
        if (rims_.empty() || hole_radius_ <= usual_)
            return {};
        const Coarse coarse = thin_around_rims(progress.part(0, 0.1));
        if (coarse.samples.points.size() < 3)
            return {};
        const double ratio = hole_radius_ / (apart * usual_);
        const Refined refined =
            refine(coarse.samples, std::clamp(int(std::ceil(std::log(ratio) / std::log(1.7))) + 1, 1, 12),
                   progress.part(0.1, 0.7));
        return keep_in_holes(refined, coarse, progress.part(0.7, 1));
    }

private:
    /// Samples as far apart as the hole is wide.
    struct Coarse
    {
        OrientedSamples samples;
        std::vector<int> origin; ///< Usable samples.
    };

    const Point& point(int i) const { return usable_.samples.points[std::size_t(i)]; }
    /// Radius of a fan without its factor: a little more than the spacing.
    double spacing(int i) const { return fans_.radius[std::size_t(i)] / 1.5; }

    Coarse thin_around_rims(const Progress& progress) const
    {
        Points rims;
        for (int i : rims_)
            rims.push_back(point(i));
        const NeighbourSearch rim_search(rims);
        const auto look = [&](std::size_t i, std::vector<int>& found)
        {
            const Point& p = usable_.samples.points[i];
            if ((p - rims[std::size_t(rim_search.nearest(p))]).norm() < 3 * hole_radius_)
                found.push_back(int(i));
        };
        std::vector<int> order = rims_; // rims first: they say how the surface enters the hole
        const std::vector<int> around =
            parallel_collect<int>(usable_.input.size(), threads_, progress, look, samples_at_once);
        order.insert(order.end(), around.begin(), around.end());
        SparseSet thinned(hole_radius_);
        Coarse coarse;
        for (int i : order)
        {
            if (thinned.has_near(point(i)))
                continue;
            thinned.add(point(i));
            coarse.samples.points.push_back(point(i));
            coarse.samples.normals.push_back(usable_.samples.normals[std::size_t(i)]);
            coarse.origin.push_back(i);
        }
        return coarse;
    }

    AddedSamples keep_in_holes(const Refined& refined, const Coarse& coarse, const Progress& progress) const
    {
        const NeighbourSearch search(usable_.samples.points);
        const std::size_t count = refined.points.size();
        std::vector<int> nearest(count);
        parallel_for(
            count, threads_, progress.part(0, 0.5),
            [&](std::size_t k) { nearest[k] = search.nearest(refined.points[k]); }, samples_at_once);
        const auto room_at = [&](std::size_t k) { return (refined.points[k] - point(nearest[k])).norm(); };
        // What is filled is the union of large empty balls: the usual unevenness of samples is left to refinement.
        Points centres;
        std::vector<double> radii;
        for (std::size_t k = 0; k < count; ++k)
            if (const double room = room_at(k); room > 1.5 * std::max(usual_, spacing(nearest[k])))
            {
                centres.push_back(refined.points[k]);
                radii.push_back(std::min(1.1 * room, 1.5 * hole_radius_));
            }
        const UnionOfBalls holes(centres, radii);

        AddedSamples fill;
        SparseSet taken(apart * usual_);
        const int n = int(usable_.input.size()), coarse_count = int(coarse.origin.size());
        std::vector<int> place(count, -1); // in usable samples followed by the fill
        for (std::size_t k = 0; k < count; ++k)
        {
            if (k % samples_at_once == 0)
                progress.part(0.5, 1).report(double(k) / double(count));
            const Point& p = refined.points[k];
            const double free = std::max(apart * usual_, apart * std::min(spacing(nearest[k]), 2 * usual_));
            std::array<int, 3> parents;
            for (std::size_t m = 0; m < 3; ++m)
            {
                const int parent = refined.parents[k][m];
                parents[m] = parent < coarse_count ? coarse.origin[std::size_t(parent)]
                                                   : place[std::size_t(parent - coarse_count)];
            }
            const auto is_frozen = [&](int parent) { return parent < n && usable_.is_frozen[std::size_t(parent)]; };
            if (room_at(k) <= free || taken.has_near(p) || std::all_of(parents.begin(), parents.end(), is_frozen) ||
                !holes.hold(p))
            {
                place[k] = parents[0]; // stands in for it among the parents of others
                continue;
            }
            place[k] = n + int(fill.samples.points.size());
            fill.samples.points.push_back(p);
            fill.samples.normals.push_back(refined.normals[k]);
            fill.parents.push_back(parents);
            taken.add(p);
        }
        return fill;
    }

    const UsableSamples& usable_;
    const InitialFans& fans_;
    const double hole_radius_;
    const int threads_;
    std::vector<int> rims_;
    double usual_ = 0; ///< Spacing on rims.
};

} // namespace

AddedSamples fill_holes(const UsableSamples& usable, const InitialFans& fans, double boundary_angle, double hole_radius,
                        const RefineCoarse& refine, int threads, const Progress& progress)
{
    return HoleFiller(usable, fans, boundary_angle, hole_radius, threads).fill(refine, progress);
}

} // namespace recon::pn
