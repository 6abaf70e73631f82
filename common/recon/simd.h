#pragma once

// Eight numbers at a time, in the compiler's vector types: the same source becomes SSE2, AVX2 or AVX-512 code. Floats,
// twice as fast, where positions about a place near by only weigh samples: they resolve 1e-7 of a width.

#include <recon/vector_clones.h>

#include <cstring>

namespace recon::simd
{

constexpr int lane_count = 8;
using Lanes = double __attribute__((vector_size(64)));
using FloatLanes = float __attribute__((vector_size(32)));

/// Number of entries that arrays must hold for n values to be read in whole Lanes.
constexpr int padded(int n)
{
    return (n + lane_count - 1) / lane_count * lane_count;
}

RECON_INLINE Lanes load(const double* values)
{
    Lanes x;
    std::memcpy(&x, values, sizeof x);
    return x;
}
RECON_INLINE FloatLanes load(const float* values)
{
    FloatLanes x;
    std::memcpy(&x, values, sizeof x);
    return x;
}
RECON_INLINE void store(double* values, Lanes x)
{
    std::memcpy(values, &x, sizeof x);
}

/// In a fixed order, so that all instruction sets round alike.
template <class AnyLanes>
RECON_INLINE double sum(AnyLanes x)
{
    return ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]));
}

RECON_INLINE Lanes zero()
{
    return Lanes{};
}

/// Four: what AVX2 compares at once. For it GCC 12 takes the comparison of longer vectors apart into single numbers,
/// which made searches three times as slow.
using HalfLanes = double __attribute__((vector_size(32)));

RECON_INLINE HalfLanes load_half(const double* values)
{
    HalfLanes x;
    std::memcpy(&x, values, sizeof x);
    return x;
}
RECON_INLINE HalfLanes larger(HalfLanes a, HalfLanes b)
{
    return a > b ? a : b;
}
/// The sum of Lanes in halves.
RECON_INLINE double sum(HalfLanes low, HalfLanes high)
{
    return ((low[0] + high[0]) + (low[2] + high[2])) + ((low[1] + high[1]) + (low[3] + high[3]));
}

/// x where a <= b, y elsewhere.
RECON_INLINE Lanes where_at_most(Lanes a, Lanes b, Lanes x, Lanes y)
{
    struct Halves
    {
        HalfLanes low, high;
    };
    Halves ha, hb, hx, hy;
    std::memcpy(&ha, &a, sizeof a);
    std::memcpy(&hb, &b, sizeof b);
    std::memcpy(&hx, &x, sizeof x);
    std::memcpy(&hy, &y, sizeof y);
    const Halves chosen{ha.low <= hb.low ? hx.low : hy.low, ha.high <= hb.high ? hx.high : hy.high};
    Lanes result;
    std::memcpy(&result, &chosen, sizeof result);
    return result;
}

/// exp(-x) for 0 <= x <= 8 to a relative 1e-6, by a polynomial for exp(-x / 16) and four squarings: no integer
/// arithmetic, which the older instruction sets lack for 64 bits.
template <class AnyLanes>
RECON_INLINE AnyLanes exp_negative(AnyLanes x)
{
    using Number = decltype(x[0] + x[0]);
    const AnyLanes t = x * Number(-1.0 / 16);
    AnyLanes y = Number(1.0 / 5040) + t * Number(1.0 / 40320);
    y = Number(1.0 / 720) + t * y;
    y = Number(1.0 / 120) + t * y;
    y = Number(1.0 / 24) + t * y;
    y = Number(1.0 / 6) + t * y;
    y = Number(0.5) + t * y;
    y = Number(1) + t * y;
    y = Number(1) + t * y;
    y *= y;
    y *= y;
    y *= y;
    return y * y;
}

} // namespace recon::simd
