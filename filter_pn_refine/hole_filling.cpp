#include "hole_filling.h"

#include "sparse_set.h"

#include <recon/median.h>
#include <recon/neighbours.h>

#include <algorithm>
#include <cmath>

namespace recon::pn
{
namespace
{

/// Points put into a hole keep this distance from each other and from the samples [spacings].
constexpr double apart = 0.6;

class HoleFiller
{
public:
    HoleFiller(const UsableSamples& usable, const InitialFans& fans, double boundary_angle, double hole_radius)
        : usable_(usable), fans_(fans), hole_radius_(hole_radius)
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

    AddedSamples fill(const std::function<Refined(const OrientedSamples&, int steps)>& refine) const
    {
        if (rims_.empty() || hole_radius_ <= usual_)
            return {};
        const Coarse coarse = thin_around_rims();
        if (coarse.samples.points.size() < 3)
            return {};
        const double ratio = hole_radius_ / (apart * usual_);
        const Refined refined =
            refine(coarse.samples, std::clamp(int(std::ceil(std::log(ratio) / std::log(1.7))) + 1, 1, 12));
        return keep_in_holes(refined, coarse);
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

    Coarse thin_around_rims() const
    {
        Points rims;
        for (int i : rims_)
            rims.push_back(point(i));
        const NeighbourSearch rim_search(rims);
        std::vector<int> order = rims_; // rims first: they say how the surface enters the hole
        for (int i = 0; i < int(usable_.input.size()); ++i)
            if ((point(i) - rims[std::size_t(rim_search.nearest(point(i)))]).norm() < 3 * hole_radius_)
                order.push_back(i);
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

    AddedSamples keep_in_holes(const Refined& refined, const Coarse& coarse) const
    {
        const NeighbourSearch search(usable_.samples.points);
        // What is filled is the union of large empty balls: the usual unevenness of samples is left to refinement.
        Points empty_centres;
        std::vector<double> empty_radii;
        for (const Point& p : refined.points)
        {
            const int nearest = search.nearest(p);
            const double radius = (p - point(nearest)).norm();
            if (radius > 1.5 * std::max(usual_, spacing(nearest)))
            {
                empty_centres.push_back(p);
                empty_radii.push_back(radius);
            }
        }
        const NeighbourSearch empty_search(empty_centres);
        std::vector<int> around;
        const auto is_in_hole = [&](const Point& p)
        {
            empty_search.within(p, 1.5 * hole_radius_, around);
            return std::any_of(
                around.begin(), around.end(),
                [&](int k) { return (p - empty_centres[std::size_t(k)]).norm() < 1.1 * empty_radii[std::size_t(k)]; });
        };

        AddedSamples fill;
        SparseSet taken(apart * usual_);
        const int n = int(usable_.input.size()), coarse_count = int(coarse.origin.size());
        std::vector<int> place(refined.points.size(), -1); // in usable samples followed by the fill
        for (std::size_t k = 0; k < refined.points.size(); ++k)
        {
            const Point& p = refined.points[k];
            const int nearest = search.nearest(p);
            const double free = std::max(apart * usual_, apart * std::min(spacing(nearest), 2 * usual_));
            std::array<int, 3> parents;
            for (std::size_t m = 0; m < 3; ++m)
            {
                const int parent = refined.parents[k][m];
                parents[m] = parent < coarse_count ? coarse.origin[std::size_t(parent)]
                                                   : place[std::size_t(parent - coarse_count)];
            }
            if ((p - point(nearest)).norm() <= free || taken.has_near(p) || !is_in_hole(p))
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
    std::vector<int> rims_;
    double usual_ = 0; ///< Spacing on rims.
};

} // namespace

AddedSamples fill_holes(const UsableSamples& usable, const InitialFans& fans, double boundary_angle, double hole_radius,
                        const std::function<Refined(const OrientedSamples&, int steps)>& refine)
{
    return HoleFiller(usable, fans, boundary_angle, hole_radius).fill(refine);
}

} // namespace recon::pn
