// Part of lanes.h, which see: the operations for processors with AVX-512.

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
/// `then` where a < b, `otherwise` elsewhere.
PN_INLINE Floats where_below(Floats a, Floats b, Floats then, Floats otherwise)
{
    return select(below(a, b), then, otherwise);
}
/// The same where a <= b.
PN_INLINE Floats where_at_most(Floats a, Floats b, Floats then, Floats otherwise)
{
    return select(at_most(a, b), then, otherwise);
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
/// Writes the lanes in the mask one after the other; up to a vector's length behind them is overwritten.
template <class Vector, class Number>
PN_INLINE void store_compressed(Mask m, Vector v, Number* to)
{
    store(to, compress(m, v));
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
