// Part of lanes.h, which see: the operations for processors with AVX2, on two halves. Written out, since GCC 12 takes
// comparisons, choices and shuffles of 64-byte vectors apart into single numbers: three times the time.

struct Halves
{
    __m256 lo, hi;
};
PN_INLINE Halves halves(Floats v)
{
    return load<Halves>(&v);
}
PN_INLINE Halves halves(Ints v)
{
    return load<Halves>(&v);
}
PN_INLINE Floats floats_of(__m256 lo, __m256 hi)
{
    const Halves h{lo, hi};
    return load<Floats>(&h);
}
#define PN_COMPARE(name, how)                                                                                          \
    PN_INLINE Mask name(Floats a, Floats b)                                                                            \
    {                                                                                                                  \
        const Halves x = halves(a), y = halves(b);                                                                     \
        return Mask(_mm256_movemask_ps(_mm256_cmp_ps(x.lo, y.lo, how))) |                                              \
               Mask(_mm256_movemask_ps(_mm256_cmp_ps(x.hi, y.hi, how))) << 8;                                          \
    }
PN_COMPARE(below, _CMP_LT_OQ)
PN_COMPARE(at_most, _CMP_LE_OQ)
PN_COMPARE(equal, _CMP_EQ_OQ)
#undef PN_COMPARE
PN_INLINE __m256 spread8(Mask m)
{
    const __m256i bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    return (__m256)_mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(int(m)), bits), bits);
}
PN_INLINE Floats select(Mask m, Floats a, Floats b)
{
    const Halves x = halves(a), y = halves(b);
    return floats_of(_mm256_blendv_ps(y.lo, x.lo, spread8(m)), _mm256_blendv_ps(y.hi, x.hi, spread8(m >> 8)));
}
PN_INLINE Ints select(Mask m, Ints a, Ints b)
{
    const Floats f = select(m, with_bits(a), with_bits(b));
    return bits_of(f);
}
#define PN_CHOOSE(name, how)                                                                                           \
    PN_INLINE Floats name(Floats a, Floats b, Floats then, Floats otherwise)                                           \
    {                                                                                                                  \
        const Halves x = halves(a), y = halves(b), t = halves(then), o = halves(otherwise);                            \
        return floats_of(_mm256_blendv_ps(o.lo, t.lo, _mm256_cmp_ps(x.lo, y.lo, how)),                                 \
                         _mm256_blendv_ps(o.hi, t.hi, _mm256_cmp_ps(x.hi, y.hi, how)));                                \
    }
PN_CHOOSE(where_below, _CMP_LT_OQ)
PN_CHOOSE(where_at_most, _CMP_LE_OQ)
#undef PN_CHOOSE
PN_INLINE Floats larger(Floats a, Floats b)
{
    const Halves x = halves(a), y = halves(b);
    return floats_of(_mm256_max_ps(x.lo, y.lo), _mm256_max_ps(x.hi, y.hi));
}
PN_INLINE Floats smaller(Floats a, Floats b)
{
    const Halves x = halves(a), y = halves(b);
    return floats_of(_mm256_min_ps(x.lo, y.lo), _mm256_min_ps(x.hi, y.hi));
}
PN_INLINE float largest(Floats v)
{
    const Halves h = halves(v);
    const __m256 a = _mm256_max_ps(h.lo, h.hi);
    const __m128 b = _mm_max_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
    const __m128 c = _mm_max_ps(b, _mm_movehl_ps(b, b));
    return _mm_cvtss_f32(_mm_max_ss(c, _mm_movehdup_ps(c)));
}
PN_INLINE int largest(Ints v)
{
    const Halves h = halves(v);
    const __m256i a = _mm256_max_epi32((__m256i)h.lo, (__m256i)h.hi);
    const __m128i b = _mm_max_epi32(_mm256_castsi256_si128(a), _mm256_extracti128_si256(a, 1));
    const __m128i c = _mm_max_epi32(b, _mm_shuffle_epi32(b, 0x4E));
    return _mm_cvtsi128_si32(_mm_max_epi32(c, _mm_shuffle_epi32(c, 0xB1)));
}
PN_INLINE float sum_of(Floats v)
{
    const Halves h = halves(v);
    const __m256 a = _mm256_add_ps(h.lo, h.hi);
    const __m128 b = _mm_add_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
    const __m128 c = _mm_add_ps(b, _mm_movehl_ps(b, b));
    return _mm_cvtss_f32(_mm_add_ss(c, _mm_movehdup_ps(c)));
}
PN_INLINE Floats root(Floats v)
{
    const Halves h = halves(v);
    return floats_of(_mm256_sqrt_ps(h.lo), _mm256_sqrt_ps(h.hi));
}
struct DoubleHalves
{
    __m256d a, b;
};
PN_INLINE Doubles root(Doubles v)
{
    const DoubleHalves d = load<DoubleHalves>(&v);
    const DoubleHalves r{_mm256_sqrt_pd(d.a), _mm256_sqrt_pd(d.b)};
    return load<Doubles>(&r);
}
PN_INLINE Mask at_most(Doubles a, Doubles b)
{
    const DoubleHalves x = load<DoubleHalves>(&a), y = load<DoubleHalves>(&b);
    return Mask(_mm256_movemask_pd(_mm256_cmp_pd(x.a, y.a, _CMP_LE_OQ))) |
           Mask(_mm256_movemask_pd(_mm256_cmp_pd(x.b, y.b, _CMP_LE_OQ))) << 4;
}
PN_INLINE __m256i pack_places(Mask m)
{
    // Of eight lanes: those in the mask first.
    const std::uint64_t expanded = _pdep_u64(m & 0xFF, 0x0101010101010101u) * 0xFF;
    return _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((long long)_pext_u64(0x0706050403020100u, expanded)));
}
PN_INLINE Floats compress(Mask m, Floats v)
{
    const Halves h = halves(v);
    alignas(64) float x[2 * lane_count];
    const __m256 zero = _mm256_setzero_ps();
    const int n = __builtin_popcount(m & 0xFF), k = __builtin_popcount(m & 0xFF00);
    _mm256_store_ps(x + 8, zero);
    _mm256_storeu_ps(x, _mm256_blendv_ps(zero, _mm256_permutevar8x32_ps(h.lo, pack_places(m)), spread8((1u << n) - 1)));
    _mm256_storeu_ps(
        x + n, _mm256_blendv_ps(zero, _mm256_permutevar8x32_ps(h.hi, pack_places(m >> 8)), spread8((1u << k) - 1)));
    return load<Floats>(x);
}
PN_INLINE Ints compress(Mask m, Ints v)
{
    return bits_of(compress(m, with_bits(v)));
}
PN_INLINE void store_compressed(Mask m, Floats v, float* to)
{
    const Halves h = halves(v);
    _mm256_storeu_ps(to, _mm256_permutevar8x32_ps(h.lo, pack_places(m)));
    _mm256_storeu_ps(to + __builtin_popcount(m & 0xFF), _mm256_permutevar8x32_ps(h.hi, pack_places(m >> 8)));
}
PN_INLINE void store_compressed(Mask m, Ints v, std::int32_t* to)
{
    store_compressed(m, with_bits(v), (float*)to);
}
PN_INLINE Ints count_smaller(Ints v, const std::int32_t* of, int n)
{
    const Halves h = halves(v);
    __m256i lo = _mm256_setzero_si256(), hi = lo;
    for (int k = 0; k < n; ++k)
    {
        const __m256i x = _mm256_set1_epi32(of[k]);
        lo = _mm256_sub_epi32(lo, _mm256_cmpgt_epi32((__m256i)h.lo, x));
        hi = _mm256_sub_epi32(hi, _mm256_cmpgt_epi32((__m256i)h.hi, x));
    }
    return bits_of(floats_of((__m256)lo, (__m256)hi));
}
PN_INLINE __m256 pick8(Halves v, __m256i p)
{
    return _mm256_blendv_ps(_mm256_permutevar8x32_ps(v.lo, p), _mm256_permutevar8x32_ps(v.hi, p),
                            (__m256)_mm256_slli_epi32(p, 28));
}
PN_INLINE Floats permute(Floats v, Ints places)
{
    const Halves x = halves(v), p = halves(places);
    return floats_of(pick8(x, (__m256i)p.lo), pick8(x, (__m256i)p.hi));
}
PN_INLINE Ints permute(Ints v, Ints places)
{
    return bits_of(permute(with_bits(v), places));
}
PN_INLINE Floats permute(Floats v, Ints places, Floats w)
{
    const Halves x = halves(v), y = halves(w), p = halves(places);
    const auto pick = [&](__m256 q)
    { return _mm256_blendv_ps(pick8(x, (__m256i)q), pick8(y, (__m256i)q), (__m256)_mm256_slli_epi32((__m256i)q, 27)); };
    return floats_of(pick(p.lo), pick(p.hi));
}
PN_INLINE Ints permute(Ints v, Ints places, Ints w)
{
    return bits_of(permute(with_bits(v), places, with_bits(w)));
}
PN_INLINE Floats gather(const float* from, Ints places)
{
    const Halves p = halves(places);
    return floats_of(_mm256_i32gather_ps(from, (__m256i)p.lo, 4), _mm256_i32gather_ps(from, (__m256i)p.hi, 4));
}
PN_INLINE Floats load_lanes(const float* from, Mask m)
{
    return floats_of(_mm256_maskload_ps(from, (__m256i)spread8(m)),
                     _mm256_maskload_ps(from + 8, (__m256i)spread8(m >> 8)));
}

#include "lanes_below_avx512.h"
