#pragma once

#include "face_sector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

/// What the neighbourhoods of section 4 are computed from, in single precision: which points are neighbours does not
/// need more digits; what is inserted is computed in double.
namespace recon::pn
{

constexpr int lane_count = 16;          ///< Numbers in a vector; see lanes.h.
constexpr float far_away = 1000;        ///< [radii] Where padding lies: it disturbs nothing there.
constexpr float least_agreement = 0.1f; ///< Normals of neighbours must agree at least so far, besides eq. 6.

constexpr int padded(int n)
{
    return (n + lane_count - 1) & ~(lane_count - 1);
}

/// Points as a structure of arrays, each aligned to whole vectors and padded to them by points far away.
struct LocalPoints
{
    float *x = nullptr, *y = nullptr, *z = nullptr, *nx = nullptr, *ny = nullptr, *nz = nullptr;
    float* radius = nullptr;
    float* largest_radius = nullptr;                ///< What it may be raised to.
    std::int32_t *leaf = nullptr, *index = nullptr; ///< Where the point comes from; of old ones the leaf is not read.
    int count = 0, capacity = 0;

    /// Makes room for n and a vector more; keeps what is there.
    void reserve(int n)
    {
        n = padded(n) + lane_count;
        if (n <= capacity)
            return;
        n = std::max(n, 2 * capacity);
        std::vector<Line> larger(rows * std::size_t(n) / lane_count);
        float* const from = reinterpret_cast<float*>(storage_.data());
        float* const to = reinterpret_cast<float*>(larger.data());
        for (std::size_t r = 0; r < rows && capacity > 0; ++r)
            std::memcpy(to + r * std::size_t(n), from + r * std::size_t(capacity),
                        sizeof(float) * std::size_t(capacity));
        storage_.swap(larger);
        capacity = n;
        float** const arrays[] = {&x, &y, &z, &nx, &ny, &nz, &radius, &largest_radius};
        for (std::size_t r = 0; r < 8; ++r)
            *arrays[r] = to + r * std::size_t(n);
        leaf = reinterpret_cast<std::int32_t*>(to + 8 * std::size_t(n));
        index = reinterpret_cast<std::int32_t*>(to + 9 * std::size_t(n));
    }
    /// Puts the lanes from `from` to the end of its vector far away.
    void pad(int from)
    {
        for (int k = from; k < padded(from); ++k)
            x[k] = y[k] = z[k] = 1e6f;
    }

private:
    struct alignas(64) Line
    {
        std::int32_t values[lane_count];
    };
    static constexpr std::size_t rows = 10;
    std::vector<Line> storage_;
};

/// A refined point in the frame of its leaf.
struct Centre
{
    float x, y, z;
    float n[3], e1[3], e2[3]; ///< Normal and tangents.
    float inverse_radius;
};

/// Tangents of a centre from its normal (Duff et al. 2017).
inline void set_tangents(Centre& c)
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

constexpr int ring_capacity = 128;
constexpr int largest_ring = 96; ///< More are thinned to this.

/// Points within the radius of a centre that its normal admits, in the centre's frame: it lies at the origin and its
/// radius is 1.
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
    alignas(64) std::int32_t source[ring_capacity];                            ///< Index among the local points.
};

/// The triangle fan: entries of the ring sorted by angle. Never more than a vector holds: of more the nearest in each
/// of as many sectors.
struct Fan
{
    int count = 0;
    alignas(64) std::int32_t entry[lane_count];
    alignas(64) float angle[lane_count];
};

} // namespace recon::pn
