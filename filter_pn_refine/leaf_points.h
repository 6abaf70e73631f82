#pragma once

#include "refine_leaf.h"
#include "ring.h"

#include <algorithm>
#include <array>

/// What a task knows of the points around its leaf: gathered once, in single precision, and searched for each of its
/// points.
namespace recon::pn
{

/// New points near the centre, in its frame. Padded like rings.
struct Arrivals
{
    int count = 0;
    alignas(64) float x[ring_capacity], y[ring_capacity], z[ring_capacity], length[ring_capacity], angle[ring_capacity],
        radius[ring_capacity];
    alignas(64) float reach[ring_capacity]; ///< Nothing may be put nearer than this.
    int source[ring_capacity];
    bool is_neighbour[ring_capacity]; ///< Belongs to N' already, or cannot.
};

/// Centres of the fan's triangles.
struct Candidates
{
    int count = 0;
    alignas(64) float x[ring_capacity], y[ring_capacity], z[ring_capacity], angle[ring_capacity];
    int a[ring_capacity], b[ring_capacity];
    bool is_used[ring_capacity];
};

/// One of N', sorted by angle.
struct Neighbour
{
    float angle;
    float gap;    ///< Angle to the next.
    int entry;    ///< In the ring or among the arrivals.
    bool is_new;  ///< Among the arrivals.
    bool is_dead; ///< Nothing can fill the gap.
};

constexpr int neighbour_capacity = 2 * ring_capacity;

struct Workspace
{
    LocalPoints old_points, new_points;
    std::vector<float> next;          ///< Per old local point: radius to raise it to.
    std::vector<float> radius_before; ///< Per new local point.
    std::vector<std::uint8_t> classes;
    std::vector<int> hits, rejected, hit_buffer, rejected_buffer;
    Ring ring;
    Arrivals arrivals;
    Candidates candidates;
    Neighbour neighbours[neighbour_capacity];
    int neighbour_count = 0;
    Point centre;
    double scale = 1;
    float usual_radius = 0;   ///< Median of the leaf's points.
    bool has_creases = false; ///< Some local point lies on one.
};

inline void append_local(LocalPoints& to, const WorkPoint& p, double largest_radius, const Workspace& w, int leaf,
                         int index)
{
    if (to.count == int(to.x.size()))
        to.reserve(std::max(256, 2 * to.count));
    const auto n = std::size_t(to.count++);
    const Vector d = (p.position - w.centre) * w.scale;
    to.x[n] = float(d.x());
    to.y[n] = float(d.y());
    to.z[n] = float(d.z());
    to.nx[n] = float(p.normal.x());
    to.ny[n] = float(p.normal.y());
    to.nz[n] = float(p.normal.z());
    to.radius[n] = float(p.radius * w.scale);
    to.largest_radius[n] = float(largest_radius * w.scale);
    to.leaf[n] = leaf;
    to.index[n] = index;
}

/// Collects the old and new points within reach of the leaf; its own old points come first.
inline void gather(const RefineStep& step, int self, Workspace& w)
{
    const Leaf& leaf = step.level.leaves[std::size_t(self)];
    w.centre = leaf.box.centre();
    w.scale = 1 / leaf.largest_radius;
    const double reach2 = leaf.largest_radius * leaf.largest_radius;
    // Exactly what other leaves of this colour cannot reach: they write radii meanwhile.
    const auto is_near = [&](const Point& p)
    { return (leaf.box.minimum - p).cwiseMax(p - leaf.box.maximum).cwiseMax(0.0).squaredNorm() <= reach2; };
    w.old_points.clear();
    w.new_points.clear();
    w.has_creases = false;
    const auto take = [&](int from)
    {
        const Leaf& other = step.level.leaves[std::size_t(from)];
        for (int i = other.begin; i < other.end; ++i)
            if (from == self || is_near(step.level.points[std::size_t(i)].position))
            {
                const WorkPoint& p = step.level.points[std::size_t(i)];
                append_local(w.old_points, p, LocalRules::shrink * p.radius, w, from, i);
                w.has_creases |= (step.level.points[std::size_t(i)].flags & WorkPoint::crease) != 0;
            }
        const std::vector<Child>& children = step.children[std::size_t(from)];
        for (std::size_t i = 0; i < children.size(); ++i)
            if (from == self || is_near(children[i].point.position))
                append_local(w.new_points, children[i].point, children[i].largest_radius, w, from, int(i));
    };
    take(self);
    for (int k = step.graph.first[std::size_t(self)]; k < step.graph.first[std::size_t(self) + 1]; ++k)
        take(step.graph.neighbour[std::size_t(k)]);
    std::array<float, leaf_capacity> radii;
    const int own = leaf.size();
    std::copy_n(w.old_points.radius.begin(), own, radii.begin());
    std::nth_element(radii.begin(), radii.begin() + own / 2, radii.begin() + own);
    w.usual_radius = radii[std::size_t(own / 2)];
    w.next.assign(std::size_t(w.old_points.count), 0.f);
    w.radius_before.assign(w.new_points.radius.begin(), w.new_points.radius.begin() + w.new_points.count);
}

/// Splits the local points around the centre into hits and rejected.
PN_INLINE void find_near(const LocalPoints& points, const Centre& c, Workspace& w)
{
    const auto n = std::size_t(points.count);
    if (w.classes.size() < n + lane_count)
        w.classes.resize(2 * n + lane_count);
    if (w.hit_buffer.size() <= n)
    {
        w.hit_buffer.resize(2 * n + 1);
        w.rejected_buffer.resize(2 * n + 1);
    }
    int found = 0, rejected = 0;
    classify_points(points, c, w.classes.data());
    list_classes(w.classes.data(), int(n), w.hit_buffer.data(), found, w.rejected_buffer.data(), rejected);
    w.hits.assign(w.hit_buffer.begin(), w.hit_buffer.begin() + found);
    w.rejected.assign(w.rejected_buffer.begin(), w.rejected_buffer.begin() + rejected);
    if (found > ring_capacity - 24)
        thin_hits(points, c, w.hits);
}

PN_INLINE void pad(Arrivals& a, int k)
{
    a.x[k] = a.y[k] = a.z[k] = far_away;
    a.reach[k] = 0;
}

PN_INLINE void fill_arrivals(const LocalPoints& points, const Centre& c, float least_distance, const Workspace& w,
                             Arrivals& a)
{
    const int hits = int(w.hits.size()), all = std::min(hits + int(w.rejected.size()), ring_capacity - 24);
    a.count = all;
    for (int k = 0; k < all; ++k)
    {
        const int j = k < hits ? w.hits[std::size_t(k)] : w.rejected[std::size_t(k - hits)];
        const auto i = std::size_t(j);
        a.source[k] = j;
        a.is_neighbour[k] = k >= hits;
        a.x[k] = points.x[i];
        a.y[k] = points.y[i];
        a.z[k] = points.z[i];
        a.radius[k] = points.radius[i];
        a.reach[k] = k < hits ? LocalRules::discard : 0;
    }
    for (int k = 0, n = padded(all); k < n; ++k)
    {
        const float x = (a.x[k] - c.x) * c.inverse_radius, y = (a.y[k] - c.y) * c.inverse_radius,
                    z = (a.z[k] - c.z) * c.inverse_radius;
        const float u = x * c.e1[0] + y * c.e1[1] + z * c.e1[2], v = x * c.e2[0] + y * c.e2[1] + z * c.e2[2];
        const float radius = a.radius[k] * c.inverse_radius, reach = a.reach[k] * radius;
        a.radius[k] = radius;
        a.reach[k] = reach > least_distance ? reach : least_distance;
        a.x[k] = x;
        a.y[k] = y;
        a.z[k] = z;
        a.length[k] = std::sqrt(x * x + y * y + z * z);
        a.angle[k] = fast_angle(u, v);
    }
    for (int k = all, n = padded(all); k < n; ++k)
        pad(a, k);
}

} // namespace recon::pn
