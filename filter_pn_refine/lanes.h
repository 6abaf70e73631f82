// Sixteen numbers at a time. No include guard: kernels.cpp includes this once per instruction set, each time in another
// namespace and after another `#pragma GCC target`, so that one program runs well on all of them. Includes nothing:
// what a target pragma covers must be ours alone.

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

PN_INLINE Mask below(Floats a, Floats b)
{
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LT_OQ);
}
PN_INLINE Mask at_most(Floats a, Floats b)
{
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LE_OQ);
}
PN_INLINE Mask equal(Floats a, Floats b)
{
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_EQ_OQ);
}
PN_INLINE Floats select(Mask m, Floats a, Floats b)
{
    return (Floats)_mm512_mask_blend_ps(__mmask16(m), (__m512)b, (__m512)a);
}
PN_INLINE Ints select(Mask m, Ints a, Ints b)
{
    return (Ints)_mm512_mask_blend_epi32(__mmask16(m), (__m512i)b, (__m512i)a);
}
PN_INLINE Floats larger(Floats a, Floats b)
{
    return (Floats)_mm512_max_ps((__m512)a, (__m512)b);
}
PN_INLINE Floats smaller(Floats a, Floats b)
{
    return (Floats)_mm512_min_ps((__m512)a, (__m512)b);
}
PN_INLINE float largest(Floats v)
{
    return _mm512_reduce_max_ps((__m512)v);
}
PN_INLINE int largest(Ints v)
{
    return _mm512_reduce_max_epi32((__m512i)v);
}
PN_INLINE float sum_of(Floats v)
{
    return _mm512_reduce_add_ps((__m512)v);
}
PN_INLINE Floats root(Floats v)
{
    return (Floats)_mm512_sqrt_ps((__m512)v);
}
PN_INLINE Doubles root(Doubles v)
{
    return (Doubles)_mm512_sqrt_pd((__m512d)v);
}
PN_INLINE Mask at_most(Doubles a, Doubles b)
{
    return _mm512_cmp_pd_mask((__m512d)a, (__m512d)b, _CMP_LE_OQ);
}
/// 1 / root(v) to 22 bits, v > 0.
PN_INLINE Floats inverse_root(Floats v)
{
    const Floats y = (Floats)_mm512_rsqrt14_ps((__m512)v);
    return y * (1.5f - 0.5f * v * y * y);
}
/// The same to 14 bits.
PN_INLINE Floats rough_inverse_root(Floats v)
{
    return (Floats)_mm512_rsqrt14_ps((__m512)v);
}
/// The lanes in the mask moved to the front.
PN_INLINE Floats compress(Mask m, Floats v)
{
    return (Floats)_mm512_maskz_compress_ps(__mmask16(m), (__m512)v);
}
PN_INLINE Ints compress(Mask m, Ints v)
{
    return (Ints)_mm512_maskz_compress_epi32(__mmask16(m), (__m512i)v);
}
/// Lane i of the result is lane places[i] (modulo 16).
PN_INLINE Floats permute(Floats v, Ints places)
{
    return (Floats)_mm512_permutexvar_ps((__m512i)places, (__m512)v);
}
PN_INLINE Ints permute(Ints v, Ints places)
{
    return (Ints)_mm512_permutexvar_epi32((__m512i)places, (__m512i)v);
}
/// The same from 32 lanes: those of w follow those of v.
PN_INLINE Floats permute(Floats v, Ints places, Floats w)
{
    return (Floats)_mm512_permutex2var_ps((__m512)v, (__m512i)places, (__m512)w);
}
PN_INLINE Ints permute(Ints v, Ints places, Ints w)
{
    return (Ints)_mm512_permutex2var_epi32((__m512i)v, (__m512i)places, (__m512i)w);
}
PN_INLINE Floats gather(const float* from, Ints places)
{
    return (Floats)_mm512_i32gather_ps((__m512i)places, from, 4);
}
/// Reads the lanes in the mask and no others, which another thread may be writing.
PN_INLINE Floats load_lanes(const float* from, Mask m)
{
    return (Floats)_mm512_maskz_loadu_ps(__mmask16(m), from);
}

/// One layer of a bitonic network; `low` are the lanes that take the lesser.
template <int distance>
PN_INLINE Ints exchange(Ints v, Mask low)
{
    const __m512i x = (__m512i)v;
    const __m512i y = distance == 1   ? _mm512_shuffle_epi32(x, _MM_PERM_CDAB)
                      : distance == 2 ? _mm512_shuffle_epi32(x, _MM_PERM_BADC)
                      : distance == 4 ? _mm512_shuffle_i32x4(x, x, 0xB1)
                                      : _mm512_shuffle_i32x4(x, x, 0x4E);
    return (Ints)_mm512_mask_blend_epi32(__mmask16(low), _mm512_max_epi32(x, y), _mm512_min_epi32(x, y));
}
/// Sorts the first n of the lanes; those behind them must be larger.
PN_INLINE Ints sort_lanes(Ints v, int n)
{
    v = exchange<1>(v, 0x9999);
    v = exchange<2>(v, 0xC3C3);
    v = exchange<1>(v, 0xA5A5);
    v = exchange<4>(v, 0xF00F);
    v = exchange<2>(v, 0xCC33);
    v = exchange<1>(v, 0xAA55);
    if (n > 8)
    {
        v = exchange<8>(v, 0x00FF);
        v = exchange<4>(v, 0x0F0F);
        v = exchange<2>(v, 0x3333);
        v = exchange<1>(v, 0x5555);
    }
    return v;
}

#else

PN_INLINE Mask mask_of(Ints m)
{
#if PN_INSTRUCTIONS == 3
    struct Halves
    {
        __m256 v[2];
    };
    const Halves h = load<Halves>(&m);
    return Mask(_mm256_movemask_ps(h.v[0])) | Mask(_mm256_movemask_ps(h.v[1])) << 8;
#elif defined(__SSE2__)
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
PN_INLINE Floats inverse_root(Floats v)
{
    return 1 / root(v);
}
PN_INLINE Floats rough_inverse_root(Floats v)
{
    return 1 / root(v);
}
template <class Vector>
PN_INLINE Vector compress(Mask m, Vector v)
{
    Vector from[1] = {v}, to[1] = {};
    for (int n = 0; m != 0; m &= m - 1, ++n)
        to[0][n] = from[0][first_of(m)];
    return to[0];
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
PN_INLINE Ints sort_lanes(Ints v, int n)
{
    alignas(64) std::int32_t x[lane_count];
    store(x, v);
    for (int i = 1; i < n; ++i)
    {
        const std::int32_t key = x[i];
        int k = i;
        for (; k > 0 && x[k - 1] > key; --k)
            x[k] = x[k - 1];
        x[k] = key;
    }
    return load<Ints>(x);
}

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
    a = select(below(ax, ay), 1.57079633f - a, a);
    a = select(below(x, Floats{}), 3.14159265f - a, a);
    return with_bits(bits_of(a) ^ (bits_of(y) & int(0x80000000)));
}
