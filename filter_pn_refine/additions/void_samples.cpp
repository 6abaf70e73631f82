#include "void_samples.h"

#include "filter_pn_refine/patch/pn_triangle.h"
#include "filter_pn_refine/step/local_rules.h"
#include "filter_pn_refine/step/sample_surface.h"

#include <recon/disjoint_sets.h>
#include <recon/parallel.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace recon::pn
{
namespace
{

constexpr double wide = 1.5; ///< Radius of the circle of a triangle that spans a void [spacings].
constexpr double room = 0.8; ///< From what is put into it to all samples [spacings].
constexpr double least_agreement_of_corners = 0.85; ///< Normals that agree less may hide anything between them.
/// Nor may the planes of so many nearest samples pass the new one at a larger sine of the angle.
constexpr int witnesses = 4;
constexpr double largest_slope = 0.2;
constexpr int longest_row = 6; ///< Triangles side by side: mostly one to three, five and six in one of fifty.
constexpr double closed = 2.4; ///< A fan that has a wider gap lies on a rim or in a fold [radians].

class VoidFinder
{
public:
    VoidFinder(const UsableSamples& usable, const InitialFans& fans, const std::vector<float>& spacing, double slack,
               const Mouths* mouths)
        : usable_(usable), samples_(usable.samples), fans_(fans), spacing_(spacing), slack_(slack), mouths_(mouths)
    {
    }

    /// Appends what belongs into the voids that a sample's fan spans.
    void look_around(std::size_t i, std::vector<ProposedSample>& found) const
    {
        if (!is_inner(i))
            return;
        const auto begin = std::size_t(fans_.first[i]), end = std::size_t(fans_.first[i + 1]);
        for (std::size_t m = begin; m < end; ++m)
        {
            std::array<int, 3> corners = {int(i), fans_.member[m], fans_.member[m + 1 < end ? m + 1 : begin]};
            // Each of its three fans makes the same of a triangle.
            std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
            const double usual = usual_spacing(corners), radius = radius_of_circle(corners, usual);
            if (radius < wide * usual || !are_firm(corners))
                continue;
            const WorkPoint made = centre_of(corners, usual);
            if (is_clear(made, usual))
                found.push_back({made.position, made.normal, radius / usual, usual, corners});
        }
    }

private:
    const Point& point(int i) const { return samples_.points[std::size_t(i)]; }
    const Vector& normal(int i) const { return samples_.normals[std::size_t(i)]; }

    bool is_inner(std::size_t i) const
    {
        return fans_.widest_gap[i] < closed && !usable_.is_crease[i] && !usable_.is_frozen[i];
    }

    double usual_spacing(const std::array<int, 3>& corners) const
    {
        double sum = 0;
        for (int c : corners)
            sum += double(spacing_[std::size_t(c)]);
        return sum / 3;
    }

    /// 0 for a triangle that refinement would not take either.
    double radius_of_circle(const std::array<int, 3>& corners, double usual) const
    {
        const Vector a = point(corners[1]) - point(corners[0]), b = point(corners[2]) - point(corners[0]);
        const double twice_area = a.cross(b).norm(),
                     longest = std::sqrt(std::max({a.squaredNorm(), b.squaredNorm(), (b - a).squaredNorm()}));
        if (longest > double(LocalRules::longest_edge) * usual ||
            twice_area <= double(LocalRules::least_height) * longest * longest)
            return 0;
        return a.norm() * b.norm() * (b - a).norm() / (2 * twice_area);
    }

    bool are_firm(const std::array<int, 3>& c) const
    {
        const auto agree = [&](int a, int b) { return normal(a).dot(normal(b)) >= least_agreement_of_corners; };
        return agree(c[0], c[1]) && agree(c[1], c[2]) && agree(c[2], c[0]) &&
               std::all_of(c.begin(), c.end(), [&](int i) { return is_inner(std::size_t(i)); });
    }

    WorkPoint centre_of(const std::array<int, 3>& corners, double usual) const
    {
        const auto corner = [&](std::size_t m) { return PointNormal<double>{point(corners[m]), normal(corners[m])}; };
        const PointNormal<double> p0 = corner(0), p1 = corner(1), p2 = corner(2);
        const PnTangents<double> tangents = pn_tangents(p0, p1, p2);
        WorkPoint made;
        made.position = pn_centre(p0.position, p1.position, p2.position, tangents);
        made.normal = pn_centre_normal(p0.position, p1.position, p2.position, tangents).normalized();
        made.spacing = float(usual);
        move_onto_sample_surface(usable_, slack_, {&p0.normal, &p1.normal, &p2.normal}, made);
        return made;
    }

    bool is_clear(const WorkPoint& made, double usual) const
    {
        int nearest[witnesses];
        double squared[witnesses];
        double reach = likely_reach(usual, witnesses);
        const int found = usable_.search->nearest(made.position, witnesses, nearest, squared, reach);
        const auto is_passed = [&](int j)
        {
            const Vector d = point(j) - made.position;
            return std::abs(d.dot(normal(j))) <= largest_slope * d.norm();
        };
        return squared[0] > room * room * usual * usual && std::all_of(nearest, nearest + found, is_passed) &&
               !(mouths_ && mouths_->hold(made.position, made.normal, usual));
    }

    const UsableSamples& usable_;
    const OrientedSamples& samples_;
    const InitialFans& fans_;
    const std::vector<float>& spacing_;
    const double slack_;
    const Mouths* mouths_;
};

/// Leaves out proposals whose triangles lie side by side in rows longer than chance makes them: bays of a rim and
/// slits, which are there on purpose.
std::vector<ProposedSample> leave_out_slits(std::vector<ProposedSample> proposed)
{
    const auto before = [](const ProposedSample& a, const ProposedSample& b) { return a.parents < b.parents; };
    const auto same = [](const ProposedSample& a, const ProposedSample& b) { return a.parents == b.parents; };
    std::sort(proposed.begin(), proposed.end(), before);
    proposed.erase(std::unique(proposed.begin(), proposed.end(), same), proposed.end());
    std::vector<std::array<int, 3>> sides; // both ends of an edge and the triangle
    for (std::size_t i = 0; i < proposed.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto [low, high] = std::minmax(proposed[i].parents[k], proposed[i].parents[(k + 1) % 3]);
            sides.push_back({low, high, int(i)});
        }
    std::sort(sides.begin(), sides.end());
    DisjointSets rows(proposed.size());
    for (std::size_t k = 1; k < sides.size(); ++k)
        if (sides[k][0] == sides[k - 1][0] && sides[k][1] == sides[k - 1][1])
            rows.join(sides[k][2], sides[k - 1][2]);
    std::vector<int> size(proposed.size(), 0);
    for (std::size_t i = 0; i < proposed.size(); ++i)
        ++size[std::size_t(rows.find(int(i)))];
    std::vector<ProposedSample> kept;
    for (std::size_t i = 0; i < proposed.size(); ++i)
        if (size[std::size_t(rows.find(int(i)))] <= longest_row)
            kept.push_back(proposed[i]);
    return kept;
}

} // namespace

AddedSamples sample_voids(const UsableSamples& usable, const InitialFans& fans, const std::vector<float>& spacing,
                          double slack, const Mouths* mouths, int threads, const Progress& progress)
{
    const VoidFinder finder(usable, fans, spacing, slack, mouths);
    std::vector<ProposedSample> found = parallel_collect<ProposedSample>(
        usable.samples.points.size(), threads, progress,
        [&](std::size_t i, std::vector<ProposedSample>& proposed) { finder.look_around(i, proposed); }, 64);
    return thin_out(leave_out_slits(std::move(found)), room);
}

} // namespace recon::pn
