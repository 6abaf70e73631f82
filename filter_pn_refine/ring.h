#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__)
#define PN_VECTOR_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define PN_VECTOR_CLONES
#endif
#define PN_INLINE inline __attribute__((always_inline))
#pragma GCC diagnostic ignored "-Wpsabi" // Lanes never cross a call: everything is inlined

/// The neighbourhoods of section 4, in single precision and in the frame of one point: it lies at the origin and its
/// radius is 1. Which points are neighbours does not need more digits; what is inserted is computed in double.
namespace recon::pn
{

/// Points around a leaf as a structure of arrays, relative to its centre.
struct LocalPoints
{
    std::vector<float> x, y, z, nx, ny, nz;
    std::vector<float> radius;
    std::vector<float> largest_radius; ///< What it may be raised to.
    std::vector<int> leaf, index;      ///< Where the point comes from.
    int count = 0;

    void clear() { count = 0; }
    void reserve(int n)
    {
        n = (n + 15) & ~15; // whole vectors are read
        if (int(x.size()) >= n)
            return;
        for (std::vector<float>* v : {&x, &y, &z, &nx, &ny, &nz, &radius, &largest_radius})
            v->resize(std::size_t(n));
        leaf.resize(std::size_t(n));
        index.resize(std::size_t(n));
    }
};

/// A refined point in the frame of its leaf.
struct Centre
{
    float x, y, z;
    float n[3], e1[3], e2[3]; ///< Normal and tangents.
    float inverse_radius;
};

constexpr int ring_capacity = 128;

/// Loops over rings run to whole vectors; what pads them lies far away and disturbs nothing.
constexpr int lane_count = 16;
using Lanes = float __attribute__((vector_size(64)));
PN_INLINE int padded(int n)
{
    return (n + lane_count - 1) & ~(lane_count - 1);
}
PN_INLINE Lanes load(const float* values)
{
    Lanes x;
    std::memcpy(&x, values, sizeof x);
    return x;
}
constexpr float far_away = 1000; ///< [radii]

/// Points within the radius of the centre that its normal admits, in the centre's frame.
struct Ring
{
    int count = 0;
    alignas(64) float x[ring_capacity], y[ring_capacity], z[ring_capacity];
    alignas(64) float nx[ring_capacity], ny[ring_capacity], nz[ring_capacity];
    alignas(64) float length[ring_capacity];
    alignas(64) float u[ring_capacity], v[ring_capacity];                      ///< Tangent-plane coordinates.
    alignas(64) float angle[ring_capacity];                                    ///< Of (u, v) [radians], -pi to pi.
    alignas(64) float tx[ring_capacity], ty[ring_capacity], tz[ring_capacity]; ///< Sum of both tangents of the curve.
    alignas(64) float flatness[ring_capacity];                                 ///< n0 . n.
    int source[ring_capacity];                                                 ///< Index among the local points.
};

/// atan2 to 2e-5, without branches.
PN_INLINE float fast_angle(float x, float y)
{
    const float ax = std::fabs(x), ay = std::fabs(y);
    const float larger = ax > ay ? ax : ay, smaller = ax > ay ? ay : ax;
    const float t = smaller / (larger + 1e-30f), s = t * t;
    float a = t * (0.9998660f + s * (-0.3302995f + s * (0.1801410f + s * (-0.0851330f + s * 0.0208351f))));
    a = ay > ax ? 1.57079633f - a : a;
    a = x < 0 ? 3.14159265f - a : a;
    return y < 0 ? -a : a;
}

/// Normals of neighbours must agree at least so far, besides eq. 6.
constexpr float least_agreement = 0.1f;

/// Sorts the points into those that may be neighbours (1), those within the radius that may not (2) and the rest (0).
/// `classes` and the arrays of `points` hold at least padded(points.count).
PN_INLINE void classify_points(const LocalPoints& points, const Centre& c, std::uint8_t* classes)
{
    const float *x = points.x.data(), *y = points.y.data(), *z = points.z.data();
    const float *nx = points.nx.data(), *ny = points.ny.data(), *nz = points.nz.data();
    const float r2 = 1 / (c.inverse_radius * c.inverse_radius);
    const float same = 1e-12f * r2;
    const int n = padded(points.count);
    for (int j = 0; j < n; ++j)
    {
        const float dx = x[j] - c.x, dy = y[j] - c.y, dz = z[j] - c.z;
        const float d2 = dx * dx + dy * dy + dz * dz;
        const float agreement = c.n[0] * nx[j] + c.n[1] * ny[j] + c.n[2] * nz[j];
        const float slope = (c.n[0] + nx[j]) * dx + (c.n[1] + ny[j]) * dy + (c.n[2] + nz[j]) * dz;
        const float limit = 1 + agreement;
        const int near = int(d2 <= r2) & int(d2 > same);
        const int consistent = int(slope * slope <= limit * limit * d2) & int(agreement >= least_agreement);
        classes[j] = std::uint8_t(near * (2 - consistent));
    }
    for (int j = points.count; j < n; ++j)
        classes[j] = 0;
}

/// Lists the points of class 1 and of class 2, ascending; both lists hold at least n. Few points of many are in either,
/// so eight are passed over at a time.
PN_INLINE void list_classes(const std::uint8_t* classes, int n, int* ones, int& one_count, int* twos, int& two_count)
{
    one_count = two_count = 0;
    for (int j = 0; j < n; j += 8)
    {
        std::uint64_t word;
        std::memcpy(&word, classes + j, 8);
        while (word != 0)
        {
            const int k = __builtin_ctzll(word) / 8;
            const bool is_one = (word >> (8 * k) & 1) != 0;
            ones[one_count] = twos[two_count] = j + k;
            one_count += is_one;
            two_count += !is_one;
            word &= ~(std::uint64_t(255) << (8 * k));
        }
    }
}

/// Keeps of too many hits the four nearest in each of 24 sectors: what the fan can hold comes from all around, also
/// where a radius reaches across a hole.
inline void thin_hits(const LocalPoints& points, const Centre& c, std::vector<int>& hits)
{
    constexpr int sectors = 24, each = 4;
    int best[sectors][each];
    float distance[sectors][each];
    int filled[sectors] = {};
    for (int j : hits)
    {
        const float dx = points.x[std::size_t(j)] - c.x, dy = points.y[std::size_t(j)] - c.y,
                    dz = points.z[std::size_t(j)] - c.z;
        const float u = dx * c.e1[0] + dy * c.e1[1] + dz * c.e1[2], v = dx * c.e2[0] + dy * c.e2[1] + dz * c.e2[2];
        const float d2 = dx * dx + dy * dy + dz * dz;
        int s = int((fast_angle(u, v) + 3.14159265f) * (sectors / 6.2831853f));
        s = s < 0 ? 0 : (s >= sectors ? sectors - 1 : s);
        int place = filled[s] < each ? filled[s]++ : each;
        if (place == each)
        {
            if (d2 >= distance[s][each - 1])
                continue;
            place = each - 1;
        }
        for (; place > 0 && distance[s][place - 1] > d2; --place)
        {
            distance[s][place] = distance[s][place - 1];
            best[s][place] = best[s][place - 1];
        }
        distance[s][place] = d2;
        best[s][place] = j;
    }
    hits.clear();
    for (int s = 0; s < sectors; ++s)
        hits.insert(hits.end(), best[s], best[s] + filled[s]);
}

/// Near a crease: drops hits from its other side, that is with normals that agree too little or, at a crease point,
/// more with another normal of that point.
inline void keep_side_of_crease(const LocalPoints& points, const Centre& c, float least, std::vector<int>& hits)
{
    std::vector<int> twins;
    const float same = 1e-12f / (c.inverse_radius * c.inverse_radius);
    for (int j = 0; j < points.count; ++j)
    {
        const auto i = std::size_t(j);
        const float dx = points.x[i] - c.x, dy = points.y[i] - c.y, dz = points.z[i] - c.z;
        if (dx * dx + dy * dy + dz * dz <= same)
            twins.push_back(j);
    }
    const auto agreement = [&](float x, float y, float z, int j)
    { return x * points.nx[std::size_t(j)] + y * points.ny[std::size_t(j)] + z * points.nz[std::size_t(j)]; };
    std::size_t kept = 0;
    for (int j : hits)
    {
        const float own = agreement(c.n[0], c.n[1], c.n[2], j);
        bool stays = own >= least;
        for (int t : twins)
            stays = stays && agreement(points.nx[std::size_t(t)], points.ny[std::size_t(t)], points.nz[std::size_t(t)],
                                       j) <= own + 1e-5f;
        if (stays)
            hits[kept++] = j;
    }
    hits.resize(kept);
}

/// Fills the ring from the local points in `hits` (at most ring_capacity).
PN_INLINE void fill_ring(const LocalPoints& points, const Centre& c, const int* hits, int count, Ring& ring)
{
    ring.count = count;
    const int n = padded(count);
    for (int k = 0; k < count; ++k)
    {
        const auto j = std::size_t(hits[k]);
        ring.source[k] = hits[k];
        ring.x[k] = points.x[j];
        ring.y[k] = points.y[j];
        ring.z[k] = points.z[j];
        ring.nx[k] = points.nx[j];
        ring.ny[k] = points.ny[j];
        ring.nz[k] = points.nz[j];
    }
    for (int k = count; k < n; ++k)
    {
        const float away = far_away / c.inverse_radius;
        ring.x[k] = c.x + away * c.e1[0];
        ring.y[k] = c.y + away * c.e1[1];
        ring.z[k] = c.z + away * c.e1[2];
        ring.nx[k] = c.n[0];
        ring.ny[k] = c.n[1];
        ring.nz[k] = c.n[2];
    }
    for (int k = 0; k < n; ++k)
    {
        const float x = (ring.x[k] - c.x) * c.inverse_radius, y = (ring.y[k] - c.y) * c.inverse_radius,
                    z = (ring.z[k] - c.z) * c.inverse_radius;
        const float d2 = x * x + y * y + z * z;
        ring.x[k] = x;
        ring.y[k] = y;
        ring.z[k] = z;
        ring.length[k] = std::sqrt(d2);
        ring.u[k] = x * c.e1[0] + y * c.e1[1] + z * c.e1[2];
        ring.v[k] = x * c.e2[0] + y * c.e2[1] + z * c.e2[2];
        ring.flatness[k] = c.n[0] * ring.nx[k] + c.n[1] * ring.ny[k] + c.n[2] * ring.nz[k];
        ring.angle[k] = fast_angle(ring.u[k], ring.v[k]);
    }
}

/// Moves (u, v) out to the geodesic distance (eq. 9) and keeps the tangents for the candidates.
PN_INLINE void project_geodesically(const Centre& c, Ring& ring)
{
    const int n = padded(ring.count);
    for (int k = 0; k < n; ++k)
    {
        const float x = ring.x[k], y = ring.y[k], z = ring.z[k], d2 = ring.length[k] * ring.length[k];
        const float s0 = x * c.n[0] + y * c.n[1] + z * c.n[2];
        const float s1 = x * ring.nx[k] + y * ring.ny[k] + z * ring.nz[k];
        const float f0 = d2 - s0 * s0, f1 = d2 - s1 * s1;
        const float flat0 = f0 > 1e-6f * d2 ? f0 : 1e-6f * d2, flat1 = f1 > 1e-6f * d2 ? f1 : 1e-6f * d2;
        const float g0 = ring.length[k] / std::sqrt(flat0), g1 = ring.length[k] / std::sqrt(flat1);
        const float ax = (x - s0 * c.n[0]) * g0, ay = (y - s0 * c.n[1]) * g0, az = (z - s0 * c.n[2]) * g0;
        const float bx = (x - s1 * ring.nx[k]) * g1, by = (y - s1 * ring.ny[k]) * g1, bz = (z - s1 * ring.nz[k]) * g1;
        const float mx = x - (ax + bx) * (1.f / 3), my = y - (ay + by) * (1.f / 3), mz = z - (az + bz) * (1.f / 3);
        const float geodesic = ring.length[k] * (2.f / 3) + std::sqrt(mx * mx + my * my + mz * mz);
        const float stretch = geodesic / std::sqrt(flat0);
        ring.u[k] *= stretch;
        ring.v[k] *= stretch;
        ring.tx[k] = (ax - bx) * (1.f / 3);
        ring.ty[k] = (ay - by) * (1.f / 3);
        ring.tz[k] = (az - bz) * (1.f / 3);
    }
}

/// Badness of each entry (eq. 8): how far it lies behind a successor and a predecessor, with the planes' fuzziness
/// theta_f = 30 degrees. `in_plane`: measured on (u, v), otherwise in space. An entry above 1 is no neighbour.
template <bool in_plane>
PN_INLINE void measure_badness(const Ring& ring, float* badness)
{
    const int count = ring.count, n = padded(count);
    alignas(64) float length[ring_capacity], inverse[ring_capacity];
    for (int j = 0; j < n; ++j)
    {
        length[j] = in_plane ? std::sqrt(ring.u[j] * ring.u[j] + ring.v[j] * ring.v[j]) : ring.length[j];
        inverse[j] = 1 / (length[j] + 1e-20f);
    }
    alignas(64) float successors[ring_capacity], predecessors[ring_capacity];
    for (int i = 0; i < n; i += lane_count)
    {
        // Sixteen entries against one at a time. The sine enters with its sign times its square: one division a pair,
        // and the root is taken of the maximum.
        const Lanes ui = load(ring.u + i), vi = load(ring.v + i), li = load(length + i);
        const Lanes xi = in_plane ? ui : load(ring.x + i), yi = in_plane ? vi : load(ring.y + i), zi = load(ring.z + i);
        const Lanes squared = li * li, least = Lanes{} - 1;
        Lanes successor = least, predecessor = least;
        for (int j = 0; j < count; ++j)
        {
            const float lj = length[j];
            const Lanes g =
                in_plane ? xi * ring.u[j] + yi * ring.v[j] : xi * ring.x[j] + yi * ring.y[j] + zi * ring.z[j];
            const Lanes along = g * inverse[j] - lj;
            const Lanes apart = squared + lj * lj - 2 * g;
            const Lanes size = along > 0 ? along : -along;
            // A point is not behind itself or its twin on a crease, whatever rounding says.
            const Lanes sine = apart > 1e-6f ? along * size / apart : least;
            const Lanes side = ui * ring.v[j] - vi * ring.u[j];
            const Lanes s = side >= 0 ? sine : least, p = side >= 0 ? least : sine;
            successor = s > successor ? s : successor;
            predecessor = p > predecessor ? p : predecessor;
        }
        std::memcpy(successors + i, &successor, sizeof successor);
        std::memcpy(predecessors + i, &predecessor, sizeof predecessor);
    }
    for (int i = 0; i < n; ++i)
    {
        const float ss = successors[i], pp = predecessors[i];
        const float s = (ss < 0 ? -1.f : 1.f) * std::sqrt(std::fabs(ss)) + 0.5f;
        const float p = (pp < 0 ? -1.f : 1.f) * std::sqrt(std::fabs(pp)) + 0.5f;
        badness[i] = (s > 0 ? s : 0) + (p > 0 ? p : 0);
    }
}

/// Order of up to `lane_count` angles without branches, by counting the lesser ones; more by insertion.
PN_INLINE void order_by_angle(const float* angles, int n, int* order)
{
    if (n > lane_count)
    {
        for (int k = 0; k < n; ++k)
        {
            int place = k;
            for (; place > 0 && angles[order[place - 1]] > angles[k]; --place)
                order[place] = order[place - 1];
            order[place] = k;
        }
        return;
    }
    alignas(64) float values[lane_count];
    for (int k = 0; k < lane_count; ++k)
        values[k] = k < n ? angles[k] : 1e9f;
    alignas(64) std::int32_t ranks[lane_count] = {};
    for (int k = 0; k < n; ++k)
    {
        const float value = values[k];
        for (int l = 0; l < lane_count; ++l) // ties keep their order
            ranks[l] += int(values[l] > value) | (int(values[l] == value) & int(l > k));
    }
    for (int k = 0; k < n; ++k)
        order[ranks[k]] = k;
}

/// Entries that stay, sorted by angle: the triangle fan. `fan` holds at least ring.count. \returns how many.
PN_INLINE int sort_fan(const Ring& ring, const float* badness, int* fan)
{
    int kept_entries[ring_capacity], order[ring_capacity];
    float angles[ring_capacity];
    int n = 0;
    for (int k = 0; k < ring.count; ++k)
    {
        kept_entries[n] = k;
        angles[n] = ring.angle[k];
        n += !(badness[k] > 1);
    }
    order_by_angle(angles, n, order);
    for (int k = 0; k < n; ++k)
        fan[k] = kept_entries[order[k]];
    // Of two normals at one position (a crease) the one that agrees more.
    int kept = 0;
    for (int k = 0; k < n; ++k)
    {
        const int a = fan[k];
        bool is_twin = false;
        for (int m = kept - 1; m >= 0 && ring.angle[fan[m]] == ring.angle[a]; --m)
            if (const int b = fan[m]; ring.x[a] == ring.x[b] && ring.y[a] == ring.y[b] && ring.z[a] == ring.z[b])
            {
                is_twin = true;
                if (ring.flatness[a] > ring.flatness[b])
                    fan[m] = a;
                break;
            }
        if (!is_twin)
            fan[kept++] = a;
    }
    return kept;
}

/// Angle from one direction to another, counter-clockwise, in [0, 2 pi).
PN_INLINE float turn(float from, float to)
{
    const float a = to - from;
    return a >= 0 ? a : a + 6.28318531f;
}

/// The same for successive ones of a list sorted by angle: directions that are equal are no full turn apart, except
/// where the last is followed by the first.
PN_INLINE float turn_to_next(float from, float to, bool is_last)
{
    return is_last ? to - from + 6.28318531f : to - from;
}

/// Tangents of a centre from its normal (Duff et al. 2017).
PN_INLINE void set_tangents(Centre& c)
{
    const float sign = c.n[2] < 0 ? -1.f : 1.f;
    const float a = -1.f / (sign + c.n[2]), b = c.n[0] * c.n[1] * a;
    c.e1[0] = 1 + sign * c.n[0] * c.n[0] * a;
    c.e1[1] = sign * b;
    c.e1[2] = -sign * c.n[0];
    c.e2[0] = b;
    c.e2[1] = sign + c.n[1] * c.n[1] * a;
    c.e2[2] = -c.n[1];
}

} // namespace recon::pn
