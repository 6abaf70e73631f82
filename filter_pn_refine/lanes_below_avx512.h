// Part of lanes_avx2.h and lanes_plain.h: what AVX-512 alone has instructions for.

PN_INLINE Floats inverse_root(Floats v)
{
    return 1 / root(v);
}
PN_INLINE Floats rough_inverse_root(Floats v)
{
    return 1 / root(v);
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
