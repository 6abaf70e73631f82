#include "initial_fans.h"

#include "crowded.h"
#include "kernels.h"

#include <recon/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace recon::pn
{
namespace
{

constexpr double full_turn = 6.283185307179586;
constexpr int most_nearest = 64;

struct FanOfSample
{
    std::array<int, lane_count> members; ///< A Fan holds no more.
    int count = 0;
    double farthest = 0, widest_gap = full_turn;
    int gap_from = -1;
    bool may_grow = true; ///< Points beyond those looked at may be members.
};

struct CreaseRule
{
    const std::vector<char>& is_crease;
    double least_agreement;
};

/// Squared diameter of the circle through the centre and two entries of a ring, in the tangent plane.
double squared_diameter(const Ring& ring, int a, int b)
{
    const double ua = ring.u[a], va = ring.v[a], ub = ring.u[b], vb = ring.v[b];
    const double du = ub - ua, dv = vb - va, turn = ua * vb - va * ub;
    return (ua * ua + va * va) * (ub * ub + vb * vb) * (du * du + dv * dv) / (turn * turn + 1e-30);
}

/// The fan over the nearest.
FanOfSample find_fan(const OrientedSamples& samples, int i, const int* nearest, int found, const CreaseRule& rule,
                     LocalPoints& local, Ring& ring)
{
    std::int32_t hits[most_nearest + 2 * lane_count];
    const Point& p = samples.points[std::size_t(i)];
    const double reach = (samples.points[std::size_t(nearest[found - 1])] - p).norm();
    FanOfSample fan;
    if (!(reach > 0))
        return fan;
    local.reserve(most_nearest);
    local.count = 0;
    for (int m = 0; m < found; ++m)
    {
        const Vector d = (samples.points[std::size_t(nearest[m])] - p) / reach;
        const Vector& n = samples.normals[std::size_t(nearest[m])];
        const int at = local.count++;
        local.x[at] = float(d.x());
        local.y[at] = float(d.y());
        local.z[at] = float(d.z());
        local.nx[at] = float(n.x());
        local.ny[at] = float(n.y());
        local.nz[at] = float(n.z());
    }
    const Vector& n = samples.normals[std::size_t(i)];
    Centre c{0, 0, 0, {float(n.x()), float(n.y()), float(n.z())}, {}, {}, 1 / 1.00001f};
    set_tangents(c);
    local.pad(local.count);
    int count = kernels().find_near(local, c, hits);
    constexpr int beside = 12; // farther from creases normals of neighbours may differ as much as elsewhere
    if (std::any_of(nearest, nearest + std::min(found, beside),
                    [&](int j) { return rule.is_crease[std::size_t(j)] != 0; }))
        count = choose_hits(local, c, float(rule.least_agreement), true, {}, {}, hits, count);
    Fan order;
    kernels().make_fan(local, c, hits, count, true, ring, order);
    const int size = order.count;
    fan.widest_gap = 0;
    // Between two members nothing outside the circle through them and the centre joins: on it their sines in eq. 8
    // cancel.
    fan.may_grow = size < 3;
    fan.count = size;
    for (int m = 0; m < size; ++m)
    {
        const int a = order.entry[m];
        fan.members[std::size_t(m)] = nearest[ring.source[a]];
        fan.farthest = std::max(fan.farthest, ring.length[a] * 1.00001 * reach);
        const double gap =
            m + 1 < size ? order.angle[m + 1] - order.angle[m] : order.angle[0] - order.angle[m] + full_turn;
        if (gap > fan.widest_gap)
        {
            fan.widest_gap = gap;
            fan.gap_from = m;
        }
        fan.may_grow |= gap > 3.1 || squared_diameter(ring, a, order.entry[m + 1 < size ? m + 1 : 0]) > 1;
    }
    if (size == 0)
        fan.widest_gap = full_turn;
    return fan;
}

} // namespace

InitialFans find_initial_fans(const OrientedSamples& samples, const BlockSearch& search, const NearestTable& nearest,
                              const std::vector<char>& is_crease, double crease_angle, double factor, int threads,
                              const Progress& progress, const InitialFans* before, const std::vector<char>& is_changed)
{
    const CreaseRule rule{is_crease, std::cos(crease_angle)};
    const int n = int(samples.points.size());
    std::vector<FanOfSample> fans(static_cast<std::size_t>(n));
    parallel_for(
        std::size_t(n), threads, progress,
        [&](std::size_t i)
        {
            if (before && !is_changed[i])
            {
                const auto begin = before->member.begin();
                FanOfSample& fan = fans[i];
                fan.count = before->first[i + 1] - before->first[i];
                std::copy_n(begin + before->first[i], fan.count, fan.members.begin());
                fan.farthest = before->farthest[i];
                fan.widest_gap = before->widest_gap[i];
                fan.gap_from = before->gap_from[i] < 0 ? -1 : before->gap_from[i] - before->first[i];
                return;
            }
            thread_local LocalPoints local;
            thread_local Ring ring;
            fans[i] = find_fan(samples, int(i), nearest.of(i), nearest.count, rule, local, ring);
            if (n > nearest.count && fans[i].may_grow)
            {
                int more[most_nearest];
                double squared[most_nearest];
                const Point& p = samples.points[i];
                const double known = (samples.points[std::size_t(nearest.of(i)[nearest.count - 1])] - p).norm();
                double reach = 1.15 * known * std::sqrt(double(most_nearest) / nearest.count);
                const int found = search.nearest(p, std::min(n, most_nearest), more, squared, reach);
                fans[i] = find_fan(samples, int(i), more, found, rule, local, ring);
            }
        },
        64);

    InitialFans result;
    result.radius.resize(std::size_t(n));
    result.farthest.resize(std::size_t(n));
    result.widest_gap.resize(std::size_t(n));
    result.gap_from.resize(std::size_t(n));
    result.first.assign(std::size_t(n) + 1, 0);
    for (std::size_t i = 0; i < std::size_t(n); ++i)
    {
        result.farthest[i] = fans[i].farthest;
        result.radius[i] = factor * fans[i].farthest;
        result.widest_gap[i] = fans[i].widest_gap;
        result.gap_from[i] = fans[i].gap_from < 0 ? -1 : result.first[i] + fans[i].gap_from;
        result.member.insert(result.member.end(), fans[i].members.begin(), fans[i].members.begin() + fans[i].count);
        result.first[i + 1] = int(result.member.size());
    }
    for (std::size_t i = 0; i < std::size_t(n); ++i)
        for (int m = result.first[i]; m < result.first[i + 1]; ++m)
        {
            const int j = result.member[std::size_t(m)];
            double& other = result.radius[std::size_t(j)];
            other = std::max(other, 1.02 * (samples.points[i] - samples.points[std::size_t(j)]).norm());
        }
    return result;
}

} // namespace recon::pn
