#include "initial_fans.h"

#include "ring.h"

#include <recon/parallel.h>

#include <algorithm>
#include <cmath>

namespace recon::pn
{
namespace
{

PN_VECTOR_CLONES int make_fan(const LocalPoints& points, const Centre& c, const int* hits, int count, Ring& ring,
                              int* fan)
{
    alignas(64) float badness[ring_capacity];
    fill_ring(points, c, hits, count, ring);
    project_geodesically(c, ring);
    measure_badness<true>(ring, badness);
    return sort_fan(ring, badness, fan);
}

PN_VECTOR_CLONES void classify(const LocalPoints& points, const Centre& c, std::uint8_t* classes)
{
    classify_points(points, c, classes);
}

struct Fan
{
    std::vector<int> members;
    double farthest = 0, widest_gap = 6.2831853;
    int gap_from = -1;
};

struct CreaseRule
{
    const std::vector<char>& is_crease;
    double least_agreement;
};

/// The fan over the k nearest.
Fan find_fan(const OrientedSamples& samples, const NeighbourSearch& search, int i, int k, const CreaseRule& rule,
             double& reach, LocalPoints& local, Ring& ring)
{
    std::vector<int> nearest(static_cast<std::size_t>(k)), hits;
    std::vector<std::uint8_t> classes;
    std::vector<double> squared(static_cast<std::size_t>(k));
    const Point& p = samples.points[std::size_t(i)];
    const int found = search.nearest(p, k, nearest.data(), squared.data());
    reach = found > 0 ? std::sqrt(squared[std::size_t(found) - 1]) : 0;
    Fan fan;
    if (!(reach > 0))
        return fan;
    local.clear();
    local.reserve(128);
    for (int m = 0; m < found; ++m)
    {
        const Vector d = (samples.points[std::size_t(nearest[std::size_t(m)])] - p) / reach;
        const Vector& n = samples.normals[std::size_t(nearest[std::size_t(m)])];
        const auto at = std::size_t(local.count++);
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
    classes.resize(std::size_t(local.count) + lane_count);
    classify(local, c, classes.data());
    for (int m = 0; m < local.count; ++m)
        if (classes[std::size_t(m)] == 1)
            hits.push_back(m);
    if (std::any_of(nearest.begin(), nearest.begin() + found,
                    [&](int j) { return rule.is_crease[std::size_t(j)] != 0; }))
        keep_side_of_crease(local, c, float(rule.least_agreement), hits);
    int order[ring_capacity];
    const int size = make_fan(local, c, hits.data(), int(hits.size()), ring, order);
    fan.widest_gap = 0;
    for (int m = 0; m < size; ++m)
    {
        const int a = order[m], b = order[m + 1 == size ? 0 : m + 1];
        fan.members.push_back(nearest[std::size_t(ring.source[a])]);
        fan.farthest = std::max(fan.farthest, ring.length[a] * 1.00001 * reach);
        const double gap = turn_to_next(ring.angle[a], ring.angle[b], m + 1 == size);
        if (gap > fan.widest_gap)
        {
            fan.widest_gap = gap;
            fan.gap_from = m;
        }
    }
    if (size == 0)
        fan.widest_gap = 6.2831853;
    return fan;
}

} // namespace

InitialFans find_initial_fans(const OrientedSamples& samples, const NeighbourSearch& search,
                              const std::vector<char>& is_crease, double crease_angle, double factor, int threads,
                              const Progress& progress)
{
    const CreaseRule rule{is_crease, std::cos(crease_angle)};
    const int n = int(samples.points.size());
    std::vector<Fan> fans(static_cast<std::size_t>(n));
    parallel_for(
        std::size_t(n), threads, progress,
        [&](std::size_t i)
        {
            thread_local LocalPoints local;
            thread_local Ring ring;
            double reach = 0;
            // A fan that is closed well within the points looked at cannot gain a member from those beyond.
            fans[i] = find_fan(samples, search, int(i), std::min(n, 24), rule, reach, local, ring);
            if (n > 24 && (fans[i].widest_gap > 1.92 || reach < 1.5 * fans[i].farthest))
                fans[i] = find_fan(samples, search, int(i), std::min(n, 64), rule, reach, local, ring);
        },
        64);

    InitialFans result;
    result.radius.resize(std::size_t(n));
    result.widest_gap.resize(std::size_t(n));
    result.gap_from.resize(std::size_t(n));
    result.first.assign(std::size_t(n) + 1, 0);
    for (std::size_t i = 0; i < std::size_t(n); ++i)
    {
        result.radius[i] = factor * fans[i].farthest;
        result.widest_gap[i] = fans[i].widest_gap;
        result.gap_from[i] = fans[i].gap_from < 0 ? -1 : result.first[i] + fans[i].gap_from;
        result.member.insert(result.member.end(), fans[i].members.begin(), fans[i].members.end());
        result.first[i + 1] = int(result.member.size());
    }
    for (std::size_t i = 0; i < std::size_t(n); ++i)
        for (int j : fans[i].members)
        {
            double& other = result.radius[std::size_t(j)];
            other = std::max(other, 1.02 * (samples.points[i] - samples.points[std::size_t(j)]).norm());
        }
    return result;
}

} // namespace recon::pn
