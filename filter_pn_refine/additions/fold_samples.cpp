#include "fold_samples.h"

#include "filter_pn_refine/patch/hermite_surface.h"

#include <recon/labelling/widest_turn.h>
#include <recon/parallel.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <utility>

namespace recon::pn
{
namespace
{

constexpr double pi = 3.141592653589793;

constexpr double open_gap = 140 * pi / 180; ///< Of a fan: no rule lets PN triangles close more [radians].
constexpr double folded = 0.3;              ///< Normals that agree less lie on two sides of a fold.
constexpr double same_side = same_side_of_fold;
constexpr double stride = 0.7;                ///< Between samples made on one walk [spacings],
constexpr int strides = 2;                    ///< so many at most.
constexpr double room = 0.55;                 ///< To the next sample of the same side [spacings].
constexpr double surrounded = 170 * pi / 180; ///< Samples around leave no wider gap [radians].
constexpr double clear = 1.5;                 ///< A fold has nothing of its side before it so far [spacings],
constexpr double clear_cone = 0.75;           ///< within the angle of this cosine.
constexpr double jutting = 0.25;              ///< No point lies farther out than all samples around [spacings].
constexpr double flat = 0.98;                 ///< Normals of a face that does not bend agree so far.
constexpr int around = 24;                    ///< Samples looked at.
constexpr int fitted = 14;                    ///< Samples that the surface interpolates.

/// What lies around a point of a walk.
struct Surroundings
{
    double room = 1e300;  ///< To the next sample of the same side [length].
    double above = 1e300; ///< Height above the nearest samples, all of which lie below; else negative.
    std::array<int, 3> parents;
    bool is_among_samples = false; ///< The walk is over.
};

class Walk
{
public:
    Walk(const UsableSamples& usable, std::size_t from, double spacing, double slack)
        : usable_(usable), from_(from), spacing_(spacing), slack_(slack)
    {
    }

    /// Walks into a direction of the tangent plane. \returns what it passed; nothing if it leads nowhere.
    std::vector<ProposedSample> go(Vector along) const
    {
        const OrientedSamples& samples = usable_.samples;
        Point p = samples.points[from_];
        std::vector<ProposedSample> passed;
        for (int k = 0; k < strides; ++k)
        {
            Vector normal;
            if (!step(p, along, normal))
                break;
            const Surroundings s = look_around(p, normal, along);
            // Where the samples end the smooth surface goes on to a tip far too long.
            const double excess = std::max(s.above - jutting * spacing_, 0.0);
            if (s.room >= room * spacing_)
                passed.push_back({p - excess * normal, normal, s.room / spacing_, spacing_, s.parents});
            if (s.is_among_samples)
                return passed;
            if (s.room < room * spacing_)
                break;
        }
        return {};
    }

private:
    /// One stride on the surface. \returns false where there is none.
    bool step(Point& p, Vector& along, Vector& normal) const
    {
        int nearest[fitted];
        double squared[fitted];
        double reach = likely_reach(spacing_, fitted);
        usable_.search->nearest(p, fitted, nearest, squared, reach);
        if (std::any_of(nearest, nearest + fitted, [&](int j) { return usable_.is_crease[std::size_t(j)] != 0; }))
            return false;
        const HermiteSurface surface(usable_.samples, nearest, fitted, p, spacing_, slack_);
        constexpr int parts = 3; // so that it follows the bend
        constexpr double length = stride / parts;
        for (int part = 0; part < parts; ++part)
        {
            Point next = p + along * (length * spacing_);
            const Vector gradient = surface.project(next);
            const double slope = gradient.norm(); // 1 at the samples
            if (!(slope > 0.2 && slope < 5) || !((next - p).norm() < 2 * length * spacing_))
                return false;
            p = next;
            normal = gradient / slope;
            along = (along - along.dot(normal) * normal).normalized();
        }
        return along.allFinite();
    }

    Surroundings look_around(const Point& p, const Vector& normal, const Vector& along) const
    {
        const OrientedSamples& samples = usable_.samples;
        Surroundings s;
        s.parents.fill(int(from_));
        int found[around];
        double squared[around];
        double reach = likely_reach(spacing_, around);
        const int count = usable_.search->nearest(p, around, found, squared, reach);
        const Vector u = normal.unitOrthogonal(), v = normal.cross(u);
        std::vector<double> angles;
        std::size_t parents = 0;
        for (int m = 0; m < count; ++m)
        {
            const auto j = std::size_t(found[m]);
            const Vector d = samples.points[j] - p;
            const double agreement = samples.normals[j].dot(normal);
            s.above = std::min(s.above, -d.dot(normal));
            if (agreement > same_side)
            {
                s.room = std::min(s.room, d.norm());
                if (parents < 3)
                    s.parents[parents++] = int(j);
                // Across the fold.
                s.is_among_samples |=
                    d.norm() < spacing_ && d.dot(along) > 0 && samples.normals[j].dot(samples.normals[from_]) < folded;
            }
            if (d.norm() < 3 * spacing_ && agreement > -same_side)
                angles.push_back(std::atan2(d.dot(v), d.dot(u)));
        }
        if (angles.size() >= 3)
            s.is_among_samples |= widest_turn(std::move(angles)) < surrounded;
        return s;
    }

    const UsableSamples& usable_;
    const std::size_t from_;
    const double spacing_, slack_;
};

/// Directions into the open gaps of a fan, a quarter turn apart [radians in the tangent frame].
std::vector<double> directions_into_gaps(const OrientedSamples& samples, const InitialFans& fans, std::size_t i,
                                         const Vector& e1, const Vector& e2)
{
    const auto begin = fans.member.begin() + fans.first[i], end = fans.member.begin() + fans.first[i + 1];
    std::vector<double> angles;
    std::transform(begin, end, std::back_inserter(angles),
                   [&](int j)
                   {
                       const Vector d = samples.points[std::size_t(j)] - samples.points[i];
                       return std::atan2(d.dot(e2), d.dot(e1));
                   });
    if (angles.empty())
        angles.push_back(0);
    std::vector<double> directions;
    for (std::size_t m = 0; m < angles.size(); ++m)
    {
        double turn = angles[(m + 1) % angles.size()] - angles[m];
        turn += turn <= 0 ? 2 * pi : 0;
        if (turn <= open_gap)
            continue;
        const int parts = int(turn / (pi / 2) + 0.5);
        for (int k = 0; k < parts; ++k)
            directions.push_back(angles[m] + turn * (k + 0.5) / parts);
    }
    return directions;
}

} // namespace

AddedSamples sample_folds(const UsableSamples& usable, const InitialFans& fans, const std::vector<float>& spacing,
                          double slack, bool has_creases, int threads, const Progress& progress)
{
    const OrientedSamples& samples = usable.samples;
    const std::size_t n = samples.points.size();
    if (usable.nearest.count < around)
        return {};
    std::vector<ProposedSample> found = parallel_collect<ProposedSample>(
        n, threads, progress,
        [&](std::size_t i, std::vector<ProposedSample>& proposed)
        {
            const Vector& normal = samples.normals[i];
            const int* const near = usable.nearest.of(i);
            // On the rim of an open surface no walk would end: this saves the attempt.
            const bool has_fold = std::any_of(
                near, near + around, [&](int j) { return samples.normals[std::size_t(j)].dot(normal) < same_side; });
            // Where edges are sharp, a face that is flat here does not bend into a fold.
            const bool is_flat = has_creases && std::all_of(near, near + fitted,
                                                            [&](int j)
                                                            {
                                                                const double a =
                                                                    samples.normals[std::size_t(j)].dot(normal);
                                                                return a < folded || a > flat;
                                                            });
            if (fans.widest_gap[i] <= open_gap || is_flat || !has_fold || !(spacing[i] > 0) || usable.is_frozen[i])
                return;
            const Vector e1 = normal.unitOrthogonal(), e2 = normal.cross(e1);
            const Walk walk(usable, i, double(spacing[i]), slack);
            for (double t : directions_into_gaps(samples, fans, i, e1, e2))
            {
                const Vector along = std::cos(t) * e1 + std::sin(t) * e2;
                // A thin sheet goes on there, however wide the gap.
                const auto goes_on = [&](int j)
                {
                    const Vector d = samples.points[std::size_t(j)] - samples.points[i];
                    const double length = d.norm();
                    return length > 0 && length < clear * double(spacing[i]) && d.dot(along) > clear_cone * length &&
                           samples.normals[std::size_t(j)].dot(normal) > same_side;
                };
                if (std::any_of(near, near + around, goes_on))
                    continue;
                const std::vector<ProposedSample> passed = walk.go(along);
                proposed.insert(proposed.end(), passed.begin(), passed.end());
            }
        },
        64);
    const auto comes_from_frozen = [&](const ProposedSample& p)
    {
        return std::all_of(p.parents.begin(), p.parents.end(),
                           [&](int j) { return usable.is_frozen[std::size_t(j)] != 0; });
    };
    found.erase(std::remove_if(found.begin(), found.end(), comes_from_frozen), found.end());
    return thin_out(std::move(found), room);
}

} // namespace recon::pn
