#include "hole_filling.h"

#include "sparse_set.h"

#include <algorithm>
#include <cmath>

namespace recon::pn
{
AddedSamples fill_holes(const UsableSamples& usable, const InitialFans& fans, double boundary_angle, double hole_radius,
                        const std::function<Refined(const OrientedSamples&, int steps)>& refine)
{
    AddedSamples fill;
    const int n = int(usable.input.size());
    // Radius of a fan without its factor: a little more than the spacing.
    const auto spacing = [&](int i) { return fans.radius[std::size_t(i)] / 1.5; };

    SparseSet near_rims(hole_radius);
    std::vector<double> rim_spacing;
    std::vector<int> order; // rims first: they say how the surface enters the hole
    for (int i = 0; i < n; ++i)
        if (fans.widest_gap[std::size_t(i)] > boundary_angle && !usable.is_crease[std::size_t(i)] && spacing(i) > 0)
        {
            order.push_back(i);
            rim_spacing.push_back(spacing(i));
            if (!near_rims.has_near(usable.samples.points[std::size_t(i)]))
                near_rims.add(usable.samples.points[std::size_t(i)]);
        }
    if (order.empty())
        return fill;
    std::nth_element(rim_spacing.begin(), rim_spacing.begin() + std::ptrdiff_t(rim_spacing.size() / 2),
                     rim_spacing.end());
    const double usual = rim_spacing[rim_spacing.size() / 2];
    if (hole_radius <= usual)
        return fill;

    Points rims;
    for (int i : order)
        rims.push_back(usable.samples.points[std::size_t(i)]);
    const NeighbourSearch rim_search(rims);
    for (int i = 0; i < n; ++i)
    {
        const Point& p = usable.samples.points[std::size_t(i)];
        if ((p - rims[std::size_t(rim_search.nearest(p))]).norm() < 3 * hole_radius)
            order.push_back(i);
    }

    SparseSet thinned(hole_radius);
    OrientedSamples coarse;
    std::vector<int> origin;
    for (int i : order)
    {
        const Point& p = usable.samples.points[std::size_t(i)];
        if (thinned.has_near(p))
            continue;
        thinned.add(p);
        coarse.points.push_back(p);
        coarse.normals.push_back(usable.samples.normals[std::size_t(i)]);
        origin.push_back(i);
    }
    if (coarse.points.size() < 3)
        return fill;
    const double ratio = hole_radius / (0.6 * usual);
    const Refined refined = refine(coarse, std::clamp(int(std::ceil(std::log(ratio) / std::log(1.7))) + 1, 1, 12));

    const NeighbourSearch search(usable.samples.points);
    // What is filled is the union of large empty balls: the usual unevenness of samples is left to refinement.
    Points empty_centres;
    std::vector<double> empty_radii;
    for (const Point& p : refined.points)
    {
        const int nearest = search.nearest(p);
        const double radius = (p - usable.samples.points[std::size_t(nearest)]).norm();
        if (radius > 1.5 * std::max(usual, spacing(nearest)))
        {
            empty_centres.push_back(p);
            empty_radii.push_back(radius);
        }
    }
    const NeighbourSearch empty_search(empty_centres);
    std::vector<int> around;
    const auto is_in_hole = [&](const Point& p)
    {
        empty_search.within(p, 1.5 * hole_radius, around);
        return std::any_of(around.begin(), around.end(),
                           [&](int k)
                           { return (p - empty_centres[std::size_t(k)]).norm() < 1.1 * empty_radii[std::size_t(k)]; });
    };
    SparseSet taken(0.6 * usual);
    const int coarse_count = int(coarse.points.size());
    std::vector<int> place(refined.points.size(), -1); // in usable samples followed by the fill
    for (std::size_t k = 0; k < refined.points.size(); ++k)
    {
        const Point& p = refined.points[k];
        const int nearest = search.nearest(p);
        const double free = std::max(0.6 * usual, 0.6 * std::min(spacing(nearest), 2 * usual));
        std::array<int, 3> parents;
        for (std::size_t m = 0; m < 3; ++m)
        {
            const int parent = refined.parents[k][m];
            parents[m] =
                parent < coarse_count ? origin[std::size_t(parent)] : place[std::size_t(parent - coarse_count)];
        }
        const bool is_inside =
            (p - usable.samples.points[std::size_t(nearest)]).norm() > free && !taken.has_near(p) && is_in_hole(p);
        if (!is_inside)
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

} // namespace recon::pn
