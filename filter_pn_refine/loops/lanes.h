// Sixteen numbers at a time. No include guard: kernels.cpp includes this once per instruction set, each time in another
// namespace and after another `#pragma GCC target`, so that one program runs well on all of them. Includes nothing of
// others: what a target pragma covers must be ours alone.

using Floats = float __attribute__((vector_size(64)));
using Ints = std::int32_t __attribute__((vector_size(64)));
using Doubles = double __attribute__((vector_size(64)));
using Mask = unsigned; ///< Bit i: lane i.

constexpr int doubles_count = 8;

constexpr Ints lane_numbers = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

PN_INLINE Floats all(float x)
{
    return Floats{} + x;
}
PN_INLINE Ints all(int x)
{
    return Ints{} + x;
}
template <class Vector>
PN_INLINE Vector load(const void* from)
{
    Vector v;
    __builtin_memcpy(&v, from, sizeof v);
    return v;
}
template <class Vector>
PN_INLINE void store(void* to, Vector v)
{
    __builtin_memcpy(to, &v, sizeof v);
}
PN_INLINE Mask first_lanes(int n)
{
    return n >= lane_count ? 0xFFFFu : (1u << n) - 1;
}
PN_INLINE int count_of(Mask m)
{
    return __builtin_popcount(m);
}
PN_INLINE int first_of(Mask m)
{
    return __builtin_ctz(m);
}
PN_INLINE Ints bits_of(Floats v)
{
    return load<Ints>(&v);
}
PN_INLINE Floats with_bits(Ints v)
{
    return load<Floats>(&v);
}
PN_INLINE Floats absolute(Floats v)
{
    return with_bits(bits_of(v) & 0x7FFFFFFF);
}

#if PN_INSTRUCTIONS == 4
#include "lanes_avx512.h"
#elif PN_INSTRUCTIONS == 3
#include "lanes_avx2.h"
#else
#include "lanes_plain.h"
#endif

/// Keys that sort as the values do (to 19 bits) and end in the lane's number.
PN_INLINE Ints keys_with_lane(Floats v)
{
    const Ints b = bits_of(v);
    return ((b ^ ((b >> 31) & 0x7FFFFFFF)) & ~15) | lane_numbers;
}
/// Places of the lanes in the mask in the order of their values; behind them any.
PN_INLINE Ints order_of(Mask m, Floats v)
{
    const int n = count_of(m);
    Ints keys = compress(m, keys_with_lane(v));
    keys = select(first_lanes(n), keys, all(0x7FFFFFFF));
    return sort_lanes(keys, n) & 15;
}
/// Of the lanes in the mask (not none) one with the largest value, to 19 bits; values >= 0.
PN_INLINE int largest_lane(Mask m, Floats v)
{
    return largest(select(m, (bits_of(v) & ~15) | lane_numbers, Ints{})) & 15;
}
/// The lane after each of the first n, cyclically.
PN_INLINE Ints successors(int n)
{
    return select(1u << (n - 1) & 0xFFFF, all(0), lane_numbers + 1);
}
/// atan2(y, x) to 2e-5.
PN_INLINE Floats angle_of(Floats x, Floats y)
{
    const Floats ax = absolute(x), ay = absolute(y);
    const Floats t = smaller(ax, ay) / (larger(ax, ay) + 1e-30f), s = t * t;
    Floats a = t * (0.9998660f + s * (-0.3302995f + s * (0.1801410f + s * (-0.0851330f + s * 0.0208351f))));
    a = where_below(ax, ay, 1.57079633f - a, a);
    a = where_below(x, Floats{}, 3.14159265f - a, a);
    return with_bits(bits_of(a) ^ (bits_of(y) & int(0x80000000)));
}
