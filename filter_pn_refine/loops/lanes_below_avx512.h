// Part of lanes_avx2.h and lanes_plain.h: what AVX-512 alone has instructions for.

PN_INLINE Floats inverse_root(Floats v)
{
    return 1 / root(v);
}
PN_INLINE Floats rough_inverse_root(Floats v)
{
    return 1 / root(v);
}
/// The first n, all different. Each goes to where as many are smaller: no branch to mispredict.
PN_INLINE Ints sort_lanes(Ints v, int n)
{
    alignas(64) std::int32_t x[lane_count], place[lane_count], sorted[lane_count];
    store(x, v);
    store(sorted, v);
    store(place, count_smaller(v, x, n));
    for (int k = 0; k < n; ++k)
        sorted[place[k]] = x[k];
    return load<Ints>(sorted);
}
