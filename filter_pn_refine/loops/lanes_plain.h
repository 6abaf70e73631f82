// Part of lanes.h, which see: the operations for any processor. What they mean is told in lanes_avx512.h.

PN_INLINE Mask mask_of(Ints m)
{
#if defined(__SSE2__)
    struct Quarters
    {
        __m128 v[4];
    };
    const Quarters q = load<Quarters>(&m);
    return Mask(_mm_movemask_ps(q.v[0])) | Mask(_mm_movemask_ps(q.v[1])) << 4 | Mask(_mm_movemask_ps(q.v[2])) << 8 |
           Mask(_mm_movemask_ps(q.v[3])) << 12;
#else
    Mask bits = 0;
    for (int i = 0; i < lane_count; ++i)
        bits |= Mask(m[i] & 1) << i;
    return bits;
#endif
}
PN_INLINE Ints spread(Mask m)
{
    constexpr Ints bits = {1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768};
    return (all(int(m)) & bits) != 0;
}
PN_INLINE Mask below(Floats a, Floats b)
{
    return mask_of(a < b);
}
PN_INLINE Mask at_most(Floats a, Floats b)
{
    return mask_of(a <= b);
}
PN_INLINE Mask equal(Floats a, Floats b)
{
    return mask_of(a == b);
}
PN_INLINE Floats select(Mask m, Floats a, Floats b)
{
    return spread(m) ? a : b;
}
PN_INLINE Ints select(Mask m, Ints a, Ints b)
{
    return spread(m) ? a : b;
}
PN_INLINE Floats where_below(Floats a, Floats b, Floats then, Floats otherwise)
{
    return a < b ? then : otherwise;
}
PN_INLINE Floats where_at_most(Floats a, Floats b, Floats then, Floats otherwise)
{
    return a <= b ? then : otherwise;
}
PN_INLINE Floats larger(Floats a, Floats b)
{
    return a > b ? a : b;
}
PN_INLINE Floats smaller(Floats a, Floats b)
{
    return a < b ? a : b;
}
template <class Vector>
PN_INLINE auto largest(Vector v)
{
    alignas(64) std::remove_reference_t<decltype(v[0])> x[lane_count];
    store(x, v);
    for (int step = lane_count / 2; step > 0; step /= 2)
        for (int i = 0; i < step; ++i)
            x[i] = x[i] > x[i + step] ? x[i] : x[i + step];
    return x[0];
}
PN_INLINE float sum_of(Floats v)
{
    alignas(64) float x[lane_count];
    store(x, v);
    for (int step = lane_count / 2; step > 0; step /= 2)
        for (int i = 0; i < step; ++i)
            x[i] += x[i + step];
    return x[0];
}
PN_INLINE Floats root(Floats v)
{
    alignas(64) float x[lane_count];
    store(x, v);
    for (int i = 0; i < lane_count; ++i)
        x[i] = __builtin_sqrtf(x[i]);
    return load<Floats>(x);
}
PN_INLINE Doubles root(Doubles v)
{
    for (int i = 0; i < doubles_count; ++i)
        v[i] = __builtin_sqrt(v[i]);
    return v;
}
PN_INLINE Mask at_most(Doubles a, Doubles b)
{
    const auto is = a <= b;
    Mask bits = 0;
    for (int i = 0; i < doubles_count; ++i)
        bits |= Mask(is[i] & 1) << i;
    return bits;
}
template <class Vector>
PN_INLINE Vector compress(Mask m, Vector v)
{
    Vector from[1] = {v}, to[1] = {};
    for (int n = 0; m != 0; m &= m - 1, ++n)
        to[0][n] = from[0][first_of(m)];
    return to[0];
}
template <class Vector, class Number>
PN_INLINE void store_compressed(Mask m, Vector v, Number* to)
{
    alignas(64) Number from[lane_count];
    store(from, v);
    for (; m != 0; m &= m - 1)
        *to++ = from[first_of(m)];
}
/// Per lane: how many of n numbers are smaller.
PN_INLINE Ints count_smaller(Ints v, const std::int32_t* of, int n)
{
    Ints count = {};
    for (int k = 0; k < n; ++k)
        count -= v > all(of[k]);
    return count;
}
template <class Vector>
PN_INLINE Vector permute(Vector v, Ints places)
{
    return __builtin_shuffle(v, places);
}
template <class Vector>
PN_INLINE Vector permute(Vector v, Ints places, Vector w)
{
    return __builtin_shuffle(v, w, places);
}
PN_INLINE Floats gather(const float* from, Ints places)
{
    alignas(64) float x[lane_count];
    for (int i = 0; i < lane_count; ++i)
        x[i] = from[places[i]];
    return load<Floats>(x);
}
PN_INLINE Floats load_lanes(const float* from, Mask m)
{
    alignas(64) float x[lane_count] = {};
    for (; m != 0; m &= m - 1)
        x[first_of(m)] = from[first_of(m)];
    return load<Floats>(x);
}

#include "lanes_below_avx512.h"
