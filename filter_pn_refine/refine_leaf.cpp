#include "refine_leaf.h"

#include "leaf_points.h"
#include "pn_triangle.h"

#include <algorithm>
#include <array>

namespace recon::pn
{
namespace
{

constexpr float full_turn = 6.28318531f, half_turn = 3.14159265f;

/// Third of |edge| along the edge turned into the plane of n: a PN tangent in single precision, for use on arrays.
PN_INLINE void add_tangent(float ex, float ey, float ez, float nx, float ny, float nz, float& x, float& y, float& z)
{
    const float d2 = ex * ex + ey * ey + ez * ez, s = ex * nx + ey * ny + ez * nz;
    const float f = d2 - s * s, flat = f > 1e-6f * d2 ? f : 1e-6f * d2 + 1e-30f;
    const float g = std::sqrt(d2 / flat) * (1.f / 3);
    x += (ex - s * nx) * g;
    y += (ey - s * ny) * g;
    z += (ez - s * nz) * g;
}

/// Centres of the triangles of the fan; none across a gap of half a turn or more, none from slivers.
PN_INLINE void list_candidates(const Centre& c, const Ring& ring, const int* fan, int size, bool displaced,
                               Candidates& out)
{
    int n = 0;
    for (int k = 0; k < size && size > 1; ++k)
    {
        const int a = fan[k], b = fan[k + 1 == size ? 0 : k + 1];
        if (turn_to_next(ring.angle[a], ring.angle[b], k + 1 == size) >= half_turn - 1e-4f)
            continue;
        const float dx = ring.x[b] - ring.x[a], dy = ring.y[b] - ring.y[a], dz = ring.z[b] - ring.z[a];
        const float cx = ring.y[a] * ring.z[b] - ring.z[a] * ring.y[b],
                    cy = ring.z[a] * ring.x[b] - ring.x[a] * ring.z[b],
                    cz = ring.x[a] * ring.y[b] - ring.y[a] * ring.x[b];
        const float longest = std::max(dx * dx + dy * dy + dz * dz,
                                       std::max(ring.length[a] * ring.length[a], ring.length[b] * ring.length[b]));
        const float twice_area2 = cx * cx + cy * cy + cz * cz; // height / longest edge = twice_area / longest
        if (twice_area2 < LocalRules::least_height * LocalRules::least_height * longest * longest)
            continue;
        if (ring.nx[a] * ring.nx[b] + ring.ny[a] * ring.ny[b] + ring.nz[a] * ring.nz[b] < 0)
            continue;
        out.a[n] = a;
        out.b[n] = b;
        out.is_used[n] = false;
        ++n;
    }
    out.count = n;
    for (int k = 0; k < n; ++k)
    {
        const int a = out.a[k], b = out.b[k];
        float x = 0, y = 0, z = 0;
        if (displaced)
        {
            const float ex = ring.x[b] - ring.x[a], ey = ring.y[b] - ring.y[a], ez = ring.z[b] - ring.z[a];
            add_tangent(ex, ey, ez, ring.nx[a], ring.ny[a], ring.nz[a], x, y, z);
            add_tangent(-ex, -ey, -ez, ring.nx[b], ring.ny[b], ring.nz[b], x, y, z);
            x += ring.tx[a] + ring.tx[b];
            y += ring.ty[a] + ring.ty[b];
            z += ring.tz[a] + ring.tz[b];
        }
        out.x[k] = (ring.x[a] + ring.x[b]) * (1.f / 3) + x * (1.f / 6);
        out.y[k] = (ring.y[a] + ring.y[b]) * (1.f / 3) + y * (1.f / 6);
        out.z[k] = (ring.z[a] + ring.z[b]) * (1.f / 3) + z * (1.f / 6);
        const float u = out.x[k] * c.e1[0] + out.y[k] * c.e1[1] + out.z[k] * c.e1[2],
                    v = out.x[k] * c.e2[0] + out.y[k] * c.e2[1] + out.z[k] * c.e2[2];
        out.angle[k] = fast_angle(u, v);
    }
}

/// The point that belongs to the triangle, in double. \returns false if it lies out of reach.
bool make_child(const WorkPoint& p, const WorkPoint& a, const WorkPoint& b, Child& child)
{
    const PointNormal<double> p0{p.position, p.normal}, p1{a.position, a.normal}, p2{b.position, b.normal};
    const PnTangents<double> t = pn_tangents(p0, p1, p2);
    child.point.position = pn_centre(p0.position, p1.position, p2.position, t);
    if (!((child.point.position - p.position).squaredNorm() <= p.radius * p.radius))
        return false;
    const Vector mean = (p.normal + a.normal + b.normal).normalized();
    const Vector normal = pn_centre_normal(p0.position, p1.position, p2.position, t);
    const double length = normal.norm();
    // A patch that folds tells less than its corners.
    child.point.normal = length > 0 && normal.dot(mean) >= 0.5 * length ? Vector(normal / length) : mean;
    child.parents = {p.id, a.id, b.id};
    return true;
}

PN_INLINE float distance2(float ax, float ay, float az, float bx, float by, float bz)
{
    return (ax - bx) * (ax - bx) + (ay - by) * (ay - by) + (az - bz) * (az - bz);
}

/// Whether a new point may not lie at (x, y, z): too near an old or a new point, or inside the discard space.
PN_INLINE bool is_discarded(float x, float y, float z, float least, const Ring& ring, const Arrivals& arrivals)
{
    const float least2 = least * least;
    int bad = int(x * x + y * y + z * z < least2);
    for (int k = 0, n = padded(ring.count); k < n; ++k)
        bad |= int(distance2(x, y, z, ring.x[k], ring.y[k], ring.z[k]) < least2);
    for (int k = 0, n = padded(arrivals.count); k < n; ++k)
        bad |= int(distance2(x, y, z, arrivals.x[k], arrivals.y[k], arrivals.z[k]) <
                   arrivals.reach[k] * arrivals.reach[k]);
    return bad != 0;
}

struct PointRefiner
{
    const RefineStep& step;
    Workspace& w;
    int leaf;
    float least_distance = 0; ///< To any point [radii].

    const WorkPoint& old_point(int local) const
    {
        return step.level.points[std::size_t(w.old_points.index[std::size_t(local)])];
    }

    struct Place
    {
        float x, y, z, length;
        Eigen::Vector3f normal;
    };
    Place place(const Neighbour& j) const
    {
        const auto e = std::size_t(j.entry);
        if (!j.is_new)
            return {
                w.ring.x[e], w.ring.y[e], w.ring.z[e], w.ring.length[e], {w.ring.nx[e], w.ring.ny[e], w.ring.nz[e]}};
        const auto i = std::size_t(w.arrivals.source[e]);
        return {w.arrivals.x[e],
                w.arrivals.y[e],
                w.arrivals.z[e],
                w.arrivals.length[e],
                {w.new_points.nx[i], w.new_points.ny[i], w.new_points.nz[i]}};
    }

    PN_INLINE float measure_gap(int from, bool curved) const
    {
        const int to = from + 1 == w.neighbour_count ? 0 : from + 1;
        const float plane = turn_to_next(w.neighbours[from].angle, w.neighbours[to].angle, to == 0);
        // The curve bends an angle by far less than what lies outside these limits.
        return !curved || plane < 0.9f || plane > 2.6f ? plane : measure_curved_gap(from, to);
    }

    /// The angle that the curve between the two sweeps (eq. 5).
    float measure_curved_gap(int from, int to) const
    {
        const Place a = place(w.neighbours[from]), b = place(w.neighbours[to]);
        const PointNormal<float> pa{{a.x, a.y, a.z}, a.normal}, pb{{b.x, b.y, b.z}, b.normal};
        const Eigen::Vector3f c1 = pa.position + pn_tangent(pa, pb.position),
                              c2 = pb.position + pn_tangent(pb, pa.position);
        const auto angle = [](const Eigen::Vector3f& p, const Eigen::Vector3f& q)
        { return fast_angle(p.dot(q), p.cross(q).norm()); };
        return angle(pa.position, c1) + angle(c1, c2) + angle(c2, pb.position);
    }

    /// N' begins with the old and new points nearer than lambda_1.
    PN_INLINE void start_neighbours()
    {
        const Ring& ring = w.ring;
        Arrivals& a = w.arrivals;
        int entries[neighbour_capacity], order[neighbour_capacity];
        float angles[neighbour_capacity];
        int n = 0;
        for (int k = 0; k < ring.count; ++k)
        {
            entries[n] = k;
            angles[n] = ring.angle[k];
            n += ring.length[k] <= LocalRules::near;
        }
        const int old = n;
        for (int k = 0; k < a.count; ++k)
        {
            entries[n] = k;
            angles[n] = a.angle[k];
            n += !a.is_neighbour[k] & (a.length[k] <= LocalRules::near);
        }
        order_by_angle(angles, n, order);
        for (int k = 0; k < n; ++k)
            w.neighbours[k] = {angles[order[k]], 0, entries[order[k]], order[k] >= old, false};
        w.neighbour_count = n;
        for (int k = old; k < n; ++k)
            mark_neighbour(entries[k]);
    }

    void mark_neighbour(int arrival)
    {
        w.arrivals.is_neighbour[arrival] = true;
        w.arrivals.reach[arrival] = std::max(LocalRules::discard_near * w.arrivals.radius[arrival], least_distance);
    }

    /// Puts an arrival where its angle belongs, without measuring gaps. \returns its place.
    int put(int arrival)
    {
        const float angle = w.arrivals.angle[arrival];
        int at = w.neighbour_count++;
        for (; at > 0 && w.neighbours[at - 1].angle > angle; --at)
            w.neighbours[at] = w.neighbours[at - 1];
        w.neighbours[at] = {angle, 0, arrival, true, false};
        mark_neighbour(arrival);
        return at;
    }

    /// Lets an arrival join N' and measures the gaps on both sides.
    void join(int arrival, bool curved)
    {
        const int at = put(arrival), before = at == 0 ? w.neighbour_count - 1 : at - 1;
        for (const int k : {before, at})
        {
            w.neighbours[k].gap = measure_gap(k, curved);
            w.neighbours[k].is_dead = false;
        }
    }

    /// Fills the gaps of N' wider than theta_c. \returns true if one stays open.
    PN_INLINE bool fill_gaps(const WorkPoint& p, const Centre& c, bool curved)
    {
        Neighbour* list = w.neighbours;
        Candidates& candidates = w.candidates;
        Arrivals& arrivals = w.arrivals;
        bool is_open = false;
        while (w.neighbour_count < neighbour_capacity)
        {
            const int n = w.neighbour_count;
            int widest = n;
            float gap = LocalRules::complete_angle, start = 0, width = full_turn;
            for (int k = 0; k < n; ++k)
            {
                const bool wider = !list[k].is_dead && list[k].gap > gap;
                gap = wider ? list[k].gap : gap;
                widest = wider ? k : widest;
            }
            if (widest == n && n > 0)
                return is_open;
            if (n > 0)
            {
                const int next = widest + 1 == n ? 0 : widest + 1;
                start = list[widest].angle;
                width = turn_to_next(start, list[next].angle, next == 0);
            }

            // The candidate in the gap's sector that halves it best.
            int best = -1;
            float best_score = LocalRules::least_turn;
            for (int k = 0; k < candidates.count; ++k)
            {
                const float t = turn(start, candidates.angle[k]), score = std::min(t, width - t);
                const bool better = !candidates.is_used[k] && score > best_score;
                best = better ? k : best;
                best_score = better ? score : best_score;
            }
            if (best >= 0)
            {
                candidates.is_used[best] = true;
                const float x = candidates.x[best], y = candidates.y[best], z = candidates.z[best];
                if (!is_discarded(x, y, z, least_distance, w.ring, arrivals))
                {
                    insert(p, c, best, curved);
                    continue;
                }
                // The nearest of the new points in this gap takes its place.
                int nearest = -1;
                float nearest2 = 1e30f;
                for (int k = 0; k < arrivals.count; ++k)
                {
                    const float t = turn(start, arrivals.angle[k]);
                    const float d2 = distance2(x, y, z, arrivals.x[k], arrivals.y[k], arrivals.z[k]);
                    if (!arrivals.is_neighbour[k] && std::min(t, width - t) >= LocalRules::least_turn && d2 < nearest2)
                    {
                        nearest = k;
                        nearest2 = d2;
                    }
                }
                if (nearest >= 0)
                    join(nearest, curved);
                continue;
            }
            for (int k = 0; k < arrivals.count; ++k)
            {
                const float t = turn(start, arrivals.angle[k]), score = std::min(t, width - t);
                if (!arrivals.is_neighbour[k] && score > best_score)
                {
                    best = k;
                    best_score = score;
                }
            }
            if (best >= 0)
            {
                join(best, curved);
                continue;
            }
            is_open = true;
            if (n == 0)
                return true;
            list[widest].is_dead = true;
        }
        return is_open;
    }

    void insert(const WorkPoint& p, const Centre& c, int candidate, bool curved)
    {
        const Candidates& from = w.candidates;
        Arrivals& a = w.arrivals;
        Child child;
        const WorkPoint& pa = old_point(w.ring.source[from.a[candidate]]);
        const WorkPoint& pb = old_point(w.ring.source[from.b[candidate]]);
        if (a.count >= ring_capacity || !make_child(p, pa, pb, child))
            return;
        std::vector<Child>& children = step.children[std::size_t(leaf)];
        child.largest_radius = LocalRules::shrink * p.radius;
        append_local(w.new_points, child.point, child.largest_radius, w, leaf, int(children.size()));
        children.push_back(child);
        const int local = w.new_points.count - 1, k = a.count++;
        if (k % lane_count == 0) // a new vector is begun
            for (int m = k; m < k + lane_count; ++m)
                pad(a, m);
        const auto j = std::size_t(local);
        a.source[k] = local;
        a.x[k] = (w.new_points.x[j] - c.x) * c.inverse_radius;
        a.y[k] = (w.new_points.y[j] - c.y) * c.inverse_radius;
        a.z[k] = (w.new_points.z[j] - c.z) * c.inverse_radius;
        const float x = a.x[k], y = a.y[k], z = a.z[k];
        a.length[k] = std::sqrt(x * x + y * y + z * z);
        a.angle[k] = fast_angle(x * c.e1[0] + y * c.e1[1] + z * c.e1[2], x * c.e2[0] + y * c.e2[1] + z * c.e2[2]);
        a.radius[k] = std::min(a.length[k], LocalRules::shrink);
        w.new_points.radius[j] = a.radius[k] / c.inverse_radius;
        join(k, curved);
    }

    PN_INLINE bool refine(int own)
    {
        const WorkPoint& p = old_point(own);
        const LocalPoints& old_points = w.old_points;
        const auto o = std::size_t(own);
        Centre c{old_points.x[o],
                 old_points.y[o],
                 old_points.z[o],
                 {old_points.nx[o], old_points.ny[o], old_points.nz[o]},
                 {},
                 {},
                 1 / old_points.radius[o]};
        set_tangents(c);
        least_distance =
            std::max(LocalRules::least_distance, LocalRules::least_usual * w.usual_radius * c.inverse_radius);

        find_near(old_points, c, w);
        if (w.has_creases)
            keep_side_of_crease(old_points, c, step.least_crease_agreement, w.hits);
        fill_ring(old_points, c, w.hits.data(), int(w.hits.size()), w.ring);
        Ring& ring = w.ring;
        bool accurate = step.precision == Precision::accurate || step.precision == Precision::fuzzy;
        if (step.precision == Precision::automatic)
        {
            float least = 1;
            for (int k = 0; k < ring.count; ++k)
                least = ring.flatness[k] < least ? ring.flatness[k] : least;
            accurate = least < LocalRules::curved_below;
        }
        alignas(64) float badness[ring_capacity];
        int fan[ring_capacity];
        if (accurate)
            project_geodesically(c, ring);
        if (accurate && step.precision != Precision::fuzzy)
            measure_badness<true>(ring, badness);
        else
            measure_badness<false>(ring, badness);
        const int fan_size = sort_fan(ring, badness, fan);
        list_candidates(c, ring, fan, fan_size, accurate, w.candidates);

        find_near(w.new_points, c, w);
        if (w.has_creases)
            reject_other_side(c);
        fill_arrivals(w.new_points, c, least_distance, w, w.arrivals);

        start_neighbours();
        for (int k = 0; k < w.neighbour_count; ++k)
            w.neighbours[k].gap = measure_gap(k, accurate);

        const bool is_open = fill_gaps(p, c, accurate);
        // A rim stays open: keeping the radius large there would only collect neighbours.
        bool is_rim = fan_size < 2;
        for (int k = 0; k < fan_size && !is_rim; ++k)
            is_rim = turn_to_next(ring.angle[fan[k]], ring.angle[fan[k + 1 == fan_size ? 0 : k + 1]],
                                  k + 1 == fan_size) > step.boundary_angle;
        const bool is_large = old_points.radius[o] > LocalRules::largest_open * w.usual_radius;
        write_radii(own, c, is_open && !is_rim && !is_large);
        return is_open;
    }

    /// New points on the other side of a crease still keep others at a distance.
    void reject_other_side(const Centre& c)
    {
        const std::vector<int> before = w.hits;
        keep_side_of_crease(w.new_points, c, step.least_crease_agreement, w.hits);
        for (std::size_t k = 0, m = 0; k < before.size(); ++k)
            if (m < w.hits.size() && w.hits[m] == before[k])
                ++m;
            else
                w.rejected.push_back(before[k]);
    }

    PN_INLINE void write_radii(int own, const Centre& c, bool is_open)
    {
        constexpr float hair = 1 + 1e-5f; // comparisons are closed
        const int n = w.neighbour_count;
        float radius2 = is_open ? LocalRules::open_radius * LocalRules::open_radius : 0;
        for (int k = 0; k < n; ++k)
        {
            const Neighbour& j = w.neighbours[k];
            const Neighbour &before = w.neighbours[k == 0 ? n - 1 : k - 1],
                            &after = w.neighbours[k + 1 == n ? 0 : k + 1];
            const auto at = [&](const Neighbour& m)
            {
                const float *x = m.is_new ? w.arrivals.x : w.ring.x, *y = m.is_new ? w.arrivals.y : w.ring.y,
                            *z = m.is_new ? w.arrivals.z : w.ring.z;
                return std::array<float, 3>{x[m.entry], y[m.entry], z[m.entry]};
            };
            const auto [x, y, z] = at(j);
            float reach2 = x * x + y * y + z * z;
            radius2 = std::max(radius2, reach2);
            if (!before.is_dead)
                reach2 = std::max(reach2, distance2_of(x, y, z, at(before)));
            if (!j.is_dead)
                reach2 = std::max(reach2, distance2_of(x, y, z, at(after)));
            const auto source = std::size_t(j.is_new ? w.arrivals.source[j.entry] : w.ring.source[j.entry]);
            float& old = (j.is_new ? w.new_points.radius : w.next)[source];
            // Nor may a point with a large radius, at the rim of a hole, raise those of all others around it.
            const float limit = (j.is_new ? w.new_points : w.old_points).largest_radius[source];
            old = std::max(old,
                           std::min(std::min(std::sqrt(reach2) * hair, LocalRules::shrink) / c.inverse_radius, limit));
        }
        float& own_next = w.next[std::size_t(own)];
        own_next = std::max(own_next, std::min(std::sqrt(radius2) * hair, LocalRules::shrink) / c.inverse_radius);
    }
    static float distance2_of(float x, float y, float z, const std::array<float, 3>& q)
    {
        return distance2(x, y, z, q[0], q[1], q[2]);
    }
};

PN_VECTOR_CLONES int refine_points_of_leaf(PointRefiner& refiner, const Leaf& leaf)
{
    int open = 0;
    for (int i = 0; i < leaf.size(); ++i)
        if (refiner.old_point(i).flags & WorkPoint::refined)
            open += refiner.refine(i);
    return open;
}

} // namespace

void refine_leaf(const RefineStep& step, int self)
{
    thread_local Workspace workspace;
    Workspace& w = workspace;
    gather(step, self, w);
    const int had = w.new_points.count;
    PointRefiner refiner{step, w, self};
    step.open_gaps[std::size_t(self)] = refine_points_of_leaf(refiner, step.level.leaves[std::size_t(self)]);

    const double unit = 1 / w.scale;
    for (int j = 0; j < w.new_points.count; ++j)
    {
        const auto i = std::size_t(j);
        if (j >= had || w.new_points.radius[i] != w.radius_before[i])
            step.children[std::size_t(w.new_points.leaf[i])][std::size_t(w.new_points.index[i])].point.radius =
                w.new_points.radius[i] * unit;
    }
    for (int j = 0; j < w.old_points.count; ++j)
    {
        if (const float raised = w.next[std::size_t(j)]; raised > 0)
        {
            double& next = step.next_radius[std::size_t(w.old_points.index[std::size_t(j)])];
            next = std::max(next, raised * unit);
        }
    }
}

} // namespace recon::pn
