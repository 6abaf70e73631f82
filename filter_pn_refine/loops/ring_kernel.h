// Neighbourhoods of section 4. No include guard: see lanes.h.

/// Lists the points within the radius of the centre but not at it. `found` holds a vector more than there are points.
/// \returns how many.
PN_INLINE int find_near(const LocalPoints& points, const Centre& c, std::int32_t* found)
{
    const Floats cx = all(c.x), cy = all(c.y), cz = all(c.z);
    const float r2 = 1 / (c.inverse_radius * c.inverse_radius);
    const Floats most = all(r2), same = all(1e-12f * r2);
    Ints numbers = lane_numbers;
    int n = 0;
    for (int j = 0; j < points.count; j += lane_count, numbers += lane_count)
    {
        const Floats dx = load<Floats>(points.x + j) - cx, dy = load<Floats>(points.y + j) - cy,
                     dz = load<Floats>(points.z + j) - cz;
        const Floats d2 = dx * dx + dy * dy + dz * dz;
        const Mask near = at_most(d2, most) & below(same, d2);
        store_compressed(near, numbers, found + n);
        n += count_of(near);
    }
    return n;
}

/// Which points the normals admit as neighbours (eq. 6): (x, y, z) from the centre, with the squared distance and the
/// agreement of the normals.
PN_INLINE Mask admitted(const Centre& c, Floats x, Floats y, Floats z, Floats nx, Floats ny, Floats nz, Floats d2,
                        Floats agreement)
{
    const Floats slope = (c.n[0] + nx) * x + (c.n[1] + ny) * y + (c.n[2] + nz) * z, limit = 1 + agreement;
    return at_most(slope * slope, limit * limit * d2) & at_most(all(least_agreement), agreement);
}

/// Fills the ring from the local points in `hits` that the normals admit (eq. 6); the others leave the list, which
/// holds a vector more than `count`.
PN_INLINE void fill_ring(const LocalPoints& points, const Centre& c, std::int32_t* hits, int count, Ring& ring)
{
    const Floats cnx = all(c.n[0]), cny = all(c.n[1]), cnz = all(c.n[2]), inverse = all(c.inverse_radius);
    bool is_full = false;
    while (!is_full)
    {
        is_full = true;
        int kept = 0;
        for (int k = 0; k < count; k += lane_count)
        {
            const Mask valid = first_lanes(count - k);
            const Ints source = select(valid, load<Ints>(hits + k), Ints{});
            const Floats x = select(valid, (gather(points.x, source) - c.x) * inverse, all(far_away * c.e1[0])),
                         y = select(valid, (gather(points.y, source) - c.y) * inverse, all(far_away * c.e1[1])),
                         z = select(valid, (gather(points.z, source) - c.z) * inverse, all(far_away * c.e1[2]));
            const Floats nx = select(valid, gather(points.nx, source), cnx),
                         ny = select(valid, gather(points.ny, source), cny),
                         nz = select(valid, gather(points.nz, source), cnz);
            const Floats d2 = x * x + y * y + z * z, agreement = cnx * nx + cny * ny + cnz * nz;
            const Mask taken = admitted(c, x, y, z, nx, ny, nz, d2, agreement) & valid;
            const Floats u = x * c.e1[0] + y * c.e1[1] + z * c.e1[2], v = x * c.e2[0] + y * c.e2[1] + z * c.e2[2];
            store(ring.source + k, source);
            store(ring.x + k, x);
            store(ring.y + k, y);
            store(ring.z + k, z);
            store(ring.nx + k, nx);
            store(ring.ny + k, ny);
            store(ring.nz + k, nz);
            store(ring.length + k, d2 * inverse_root(d2 + 1e-30f));
            store(ring.u + k, u);
            store(ring.v + k, v);
            store(ring.flatness + k, agreement);
            store(ring.angle + k, angle_of(u, v));
            // Few are ever refused: then all is done again without them.
            if (taken != valid)
            {
                store_compressed(taken, source, hits + kept);
                is_full = false;
            }
            else if (!is_full)
                store(hits + kept, source);
            kept += count_of(taken);
        }
        count = kept;
    }
    ring.count = count;
}

/// Tangents of the curves from the centre, for the candidates; moves (u, v) out to the geodesic distance if asked (eq.
/// 9).
PN_INLINE void find_tangents(const Centre& c, bool projects, Ring& ring)
{
    for (int k = 0; k < ring.count; k += lane_count)
    {
        const Floats x = load<Floats>(ring.x + k), y = load<Floats>(ring.y + k), z = load<Floats>(ring.z + k);
        const Floats nx = load<Floats>(ring.nx + k), ny = load<Floats>(ring.ny + k), nz = load<Floats>(ring.nz + k);
        const Floats length = load<Floats>(ring.length + k), d2 = length * length;
        const Floats s0 = x * c.n[0] + y * c.n[1] + z * c.n[2], s1 = x * nx + y * ny + z * nz;
        const Floats least = 1e-6f * d2;
        const Floats i0 = inverse_root(larger(d2 - s0 * s0, least)), i1 = inverse_root(larger(d2 - s1 * s1, least));
        const Floats g0 = length * i0, g1 = length * i1;
        const Floats ax = (x - s0 * c.n[0]) * g0, ay = (y - s0 * c.n[1]) * g0, az = (z - s0 * c.n[2]) * g0;
        const Floats bx = (x - s1 * nx) * g1, by = (y - s1 * ny) * g1, bz = (z - s1 * nz) * g1;
        store(ring.tx + k, (ax - bx) * (1.f / 3));
        store(ring.ty + k, (ay - by) * (1.f / 3));
        store(ring.tz + k, (az - bz) * (1.f / 3));
        if (!projects)
            continue;
        const Floats mx = x - (ax + bx) * (1.f / 3), my = y - (ay + by) * (1.f / 3), mz = z - (az + bz) * (1.f / 3);
        const Floats stretch = (length * (2.f / 3) + root(mx * mx + my * my + mz * mz)) * i0;
        store(ring.u + k, load<Floats>(ring.u + k) * stretch);
        store(ring.v + k, load<Floats>(ring.v + k) * stretch);
    }
}

/// Which of sixteen entries are neighbours (eq. 8): how far each lies behind a successor and a predecessor, with the
/// planes' fuzziness theta_f = 30 degrees: a weight of eq. 8 is the sine + 1/2, at least 0. What lies far before one
/// plane may lie a little farther behind the other where the normals agree: without any limit the two sines cancel on
/// the circle through the centre and both neighbours, so that beside a hole, of whose rim the limit would hide the far
/// points, fans keep to Delaunay triangles. `in_plane`: measured on (u, v), otherwise in space.
template <bool in_plane>
PN_INLINE Mask choose_neighbours(const Ring& ring, int first)
{
    const Floats ui = load<Floats>(ring.u + first), vi = load<Floats>(ring.v + first);
    const Floats xi = in_plane ? ui : load<Floats>(ring.x + first), yi = in_plane ? vi : load<Floats>(ring.y + first),
                 zi = load<Floats>(ring.z + first);
    const Floats squared = in_plane ? ui * ui + vi * vi : xi * xi + yi * yi + zi * zi, least = all(-1.f);
    Floats successor = least, predecessor = least;
    for (int j = 0; j < ring.count; ++j)
    {
        const float uj = ring.u[j], vj = ring.v[j],
                    lj2 = in_plane ? uj * uj + vj * vj : ring.length[j] * ring.length[j];
        const Floats g = in_plane ? xi * uj + yi * vj : xi * ring.x[j] + yi * ring.y[j] + zi * ring.z[j];
        // The sine of a_ij, (p_j / |p_j|) . (p_i - p_j) / |p_i - p_j|. A point is not behind itself or its twin on a
        // crease, whatever rounding says.
        const Floats along = g - lj2, apart = squared + lj2 - 2 * g;
        const Floats sine = where_below(all(1e-6f), apart, along * rough_inverse_root(apart * (lj2 + 1e-30f)), least);
        const Floats side = ui * vj - vi * uj; // at least 0 of a successor
        successor = larger(successor, where_at_most(Floats{}, side, sine, least));
        predecessor = larger(predecessor, where_at_most(Floats{}, side, least, sine));
    }
    const Floats limit =
        where_at_most(all(LocalRules::firm), load<Floats>(ring.flatness + first), all(-0.9f), all(-0.5f));
    return at_most(larger(successor, limit) + larger(predecessor, limit), Floats{}) & first_lanes(ring.count - first);
}

/// Of two normals at one position (a crease) the one that agrees more stays.
inline void drop_twins(const Ring& ring, Fan& fan)
{
    int kept = 0;
    for (int k = 0; k < fan.count; ++k)
    {
        const int a = fan.entry[k];
        bool is_twin = false;
        for (int m = kept - 1; m >= 0 && fan.angle[m] == fan.angle[k]; --m)
            if (const int b = fan.entry[m]; ring.x[a] == ring.x[b] && ring.y[a] == ring.y[b] && ring.z[a] == ring.z[b])
            {
                is_twin = true;
                if (ring.flatness[a] > ring.flatness[b])
                    fan.entry[m] = a;
                break;
            }
        if (!is_twin)
        {
            fan.entry[kept] = a;
            fan.angle[kept++] = fan.angle[k];
        }
    }
    fan.count = kept;
}

/// Of more directions than a vector holds, the nearest in each of its sectors. \returns how many stay.
inline int thin_to_sectors(const float* angle, const float* length, std::int32_t* entry, int n, float* kept_angle)
{
    int best[lane_count];
    std::fill_n(best, lane_count, -1);
    for (int k = 0; k < n; ++k)
    {
        const int s = std::clamp(int((angle[k] + 3.14159265f) * (lane_count / 6.2831853f)), 0, lane_count - 1);
        if (best[s] < 0 || length[k] < length[best[s]])
            best[s] = k;
    }
    int kept = 0;
    std::int32_t entries[lane_count];
    for (int s = 0; s < lane_count; ++s)
        if (best[s] >= 0)
        {
            kept_angle[kept] = angle[best[s]];
            entries[kept++] = entry[best[s]];
        }
    std::copy_n(entries, kept, entry);
    return kept;
}

/// The neighbours among the ring, sorted by angle.
PN_INLINE void sort_fan(const Ring& ring, bool in_plane, Fan& fan)
{
    const auto choose = [&](int first)
    { return in_plane ? choose_neighbours<true>(ring, first) : choose_neighbours<false>(ring, first); };
    Floats angle;
    Ints entry;
    if (ring.count <= lane_count)
    {
        const Mask chosen = choose(0);
        fan.count = count_of(chosen);
        entry = order_of(chosen, load<Floats>(ring.angle));
        angle = permute(load<Floats>(ring.angle), entry);
    }
    else
    {
        alignas(64) float angles[ring_capacity], lengths[ring_capacity], thinned[lane_count];
        alignas(64) std::int32_t entries[ring_capacity];
        int n = 0;
        for (int k = 0; k < ring.count; k += lane_count)
        {
            const Mask chosen = choose(k);
            store_compressed(chosen, load<Floats>(ring.angle + k), angles + n);
            store_compressed(chosen, load<Floats>(ring.length + k), lengths + n);
            store_compressed(chosen, lane_numbers + k, entries + n);
            n += count_of(chosen);
        }
        const float* kept = angles;
        if (n > lane_count)
        {
            n = thin_to_sectors(angles, lengths, entries, n, thinned);
            kept = thinned;
        }
        fan.count = n;
        const Ints order = order_of(first_lanes(n), load<Floats>(kept));
        angle = permute(load<Floats>(kept), order);
        entry = permute(load<Ints>(entries), order);
    }
    store(fan.angle, angle);
    store(fan.entry, entry);
    if (fan.count > 1 && (equal(angle, permute(angle, lane_numbers + 1)) & first_lanes(fan.count - 1)) != 0)
        drop_twins(ring, fan);
}
