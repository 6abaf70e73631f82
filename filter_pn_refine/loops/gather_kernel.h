// Points around a leaf. No include guard: see lanes.h.

/// Appends those of a leaf's points that lie within 1 of the box; `offset` leads from the rows' origin to the box's
/// centre.
PN_INLINE void gather_rows(const RowsView& from, int leaf, int first_index, float scale, const float* offset,
                           const float* half_box, bool takes_all, LocalPoints& to)
{
    to.reserve(to.count + from.count);
    for (int k = 0; k < from.count; k += lane_count)
    {
        const Floats x = load<Floats>(from.x + k) * scale + offset[0], y = load<Floats>(from.y + k) * scale + offset[1],
                     z = load<Floats>(from.z + k) * scale + offset[2];
        const Floats dx = larger(absolute(x) - half_box[0], Floats{}), dy = larger(absolute(y) - half_box[1], Floats{}),
                     dz = larger(absolute(z) - half_box[2], Floats{});
        Mask taken = first_lanes(from.count - k);
        if (!takes_all)
            taken &= at_most(dx * dx + dy * dy + dz * dz, all(1 + 1e-5f));
        if (taken == 0)
            continue;
        const int n = to.count;
        const Floats radius = load_lanes(from.radius + k, taken) * scale;
        store_compressed(taken, x, to.x + n);
        store_compressed(taken, y, to.y + n);
        store_compressed(taken, z, to.z + n);
        store_compressed(taken, load<Floats>(from.nx + k), to.nx + n);
        store_compressed(taken, load<Floats>(from.ny + k), to.ny + n);
        store_compressed(taken, load<Floats>(from.nz + k), to.nz + n);
        store_compressed(taken, radius, to.radius + n);
        store_compressed(taken,
                         from.largest_radius != nullptr ? load<Floats>(from.largest_radius + k) * scale
                                                        : radius * LocalRules::shrink,
                         to.largest_radius + n);
        store(to.leaf + n, all(leaf));
        store_compressed(taken, lane_numbers + (first_index + k), to.index + n);
        to.count += count_of(taken);
    }
}
