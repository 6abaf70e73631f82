// What may be put around a refined point, and what is there already. No include guard: see lanes.h.

/// Centres of the triangles of the fan; none across a gap of half a turn or more, none from slivers or from triangles
/// that are large against the spacing, none out of reach. \returns the fan's widest gap.
PN_INLINE float list_candidates(const Centre& c, const Ring& ring, const Fan& fan, float least_distance, float spacing,
                                Candidates& out)
{
    const int n = fan.count;
    out.usable = out.firm = 0;
    if (n < 2)
        return 6.28318531f;
    const Ints entry = load<Ints>(fan.entry), next = successors(n);
    const bool is_single = ring.count <= lane_count;
    const auto pick = [&](const float* values) {
        return is_single ? permute(load<Floats>(values), entry) : gather(values, select(first_lanes(n), entry, Ints{}));
    };
    const Floats angle = load<Floats>(fan.angle);
    const Floats turn = permute(angle, next) - angle + select(1u << (n - 1), all(6.28318531f), Floats{});
    const Floats ax = pick(ring.x), ay = pick(ring.y), az = pick(ring.z), length = pick(ring.length);
    const Floats anx = pick(ring.nx), any = pick(ring.ny), anz = pick(ring.nz);
    const Floats atx = pick(ring.tx), aty = pick(ring.ty), atz = pick(ring.tz);
    const Floats bx = permute(ax, next), by = permute(ay, next), bz = permute(az, next);
    const Floats bnx = permute(anx, next), bny = permute(any, next), bnz = permute(anz, next);
    const Floats ex = bx - ax, ey = by - ay, ez = bz - az;
    const Floats cx = ay * bz - az * by, cy = az * bx - ax * bz, cz = ax * by - ay * bx;
    const Floats a2 = length * length, longest = larger(ex * ex + ey * ey + ez * ez, larger(a2, permute(a2, next)));
    // Height / longest edge = twice the area / longest edge squared.
    constexpr float least = LocalRules::least_height * LocalRules::least_height;
    const float most = LocalRules::longest_edge * spacing;
    Mask usable = first_lanes(n) & below(turn, all(3.14159265f - 1e-4f)) &
                  at_most(least * longest * longest, cx * cx + cy * cy + cz * cz) & at_most(longest, all(most * most)) &
                  at_most(Floats{}, anx * bnx + any * bny + anz * bnz);
    Floats x = atx + permute(atx, next), y = aty + permute(aty, next), z = atz + permute(atz, next);
    add_tangent(ex, ey, ez, anx, any, anz, x, y, z);
    add_tangent(-ex, -ey, -ez, bnx, bny, bnz, x, y, z);
    x = (ax + bx) * (1.f / 3) + x * (1.f / 6);
    y = (ay + by) * (1.f / 3) + y * (1.f / 6);
    z = (az + bz) * (1.f / 3) + z * (1.f / 6);
    // What lies beyond the radius is not known, so that a candidate keeps its distance to that as well.
    const float reach = std::max(1 - least_distance, 0.f);
    usable &= at_most(x * x + y * y + z * z, all(reach * reach));
    const Floats mx = anx + bnx + c.n[0], my = any + bny + c.n[1], mz = anz + bnz + c.n[2],
                 scale = inverse_root(mx * mx + my * my + mz * mz + 1e-30f);
    store(out.x, x);
    store(out.y, y);
    store(out.z, z);
    store(out.nx, mx * scale);
    store(out.ny, my * scale);
    store(out.nz, mz * scale);
    store(out.angle, angle_of(x * c.e1[0] + y * c.e1[1] + z * c.e1[2], x * c.e2[0] + y * c.e2[1] + z * c.e2[2]));
    out.usable = usable;
    const Floats flatness = pick(ring.flatness);
    out.firm = at_most(all(LocalRules::firm),
                       smaller(smaller(flatness, permute(flatness, next)), anx * bnx + any * bny + anz * bnz));
    return largest(select(first_lanes(n), turn, Floats{}));
}

/// Takes the new points around the centre into its frame.
PN_INLINE void fill_arrivals(const LocalPoints& points, const Centre& c, const std::int32_t* hits, int found,
                             float spacing, float least_distance, Arrivals& a)
{
    a.count = found;
    const Floats inverse = all(c.inverse_radius);
    const Floats cnx = all(c.n[0]), cny = all(c.n[1]), cnz = all(c.n[2]);
    for (int k = 0; k < a.count; k += lane_count)
    {
        const Mask valid = first_lanes(a.count - k);
        const Ints source = select(valid, load<Ints>(hits + k), Ints{});
        const Floats away = all(far_away);
        const Floats x = select(valid, (gather(points.x, source) - c.x) * inverse, away),
                     y = select(valid, (gather(points.y, source) - c.y) * inverse, away),
                     z = select(valid, (gather(points.z, source) - c.z) * inverse, away);
        const Floats nx = gather(points.nx, source), ny = gather(points.ny, source), nz = gather(points.nz, source);
        const Floats radius = gather(points.radius, source) * inverse;
        const Floats d2 = x * x + y * y + z * z, agreement = cnx * nx + cny * ny + cnz * nz;
        const Mask free = admitted(c, x, y, z, nx, ny, nz, d2, agreement) & valid;
        const Floats least = all(least_distance);
        store(a.source + k, source);
        store(a.x + k, x);
        store(a.y + k, y);
        store(a.z + k, z);
        store(a.nx + k, nx);
        store(a.ny + k, ny);
        store(a.nz + k, nz);
        store(a.length + k, d2 * inverse_root(d2 + 1e-30f));
        store(a.angle + k, angle_of(x * c.e1[0] + y * c.e1[1] + z * c.e1[2], x * c.e2[0] + y * c.e2[1] + z * c.e2[2]));
        const Floats reach = smaller(smaller(radius, all(LocalRules::discard_most)) * LocalRules::discard,
                                     all(LocalRules::discard_spacings * spacing));
        store(a.reach + k, larger(select(free, reach, least), least));
        store(a.near_reach + k,
              larger(smaller(radius * LocalRules::discard_near, all(LocalRules::near_spacings * spacing)), least));
        a.free[k / lane_count] = free;
    }
}

/// The new point in the gap nearest to (x, y, z), -1 if there is none.
PN_INLINE int nearest_arrival(const Arrivals& a, Floats start, Floats width, float x, float y, float z)
{
    int best = -1;
    float nearest = 1e30f;
    for (int k = 0; k < a.count; k += lane_count)
    {
        const Mask there = a.free[k / lane_count] &
                           at_most(all(LocalRules::least_turn), halving(load<Floats>(a.angle + k), start, width));
        if (there == 0)
            continue;
        const Floats dx = load<Floats>(a.x + k) - x, dy = load<Floats>(a.y + k) - y, dz = load<Floats>(a.z + k) - z;
        const Floats d2 = dx * dx + dy * dy + dz * dz;
        const int lane = largest_lane(there, 4 - d2);
        if (d2[lane] < nearest)
        {
            nearest = d2[lane];
            best = k + lane;
        }
    }
    return best;
}

/// The new point that halves the gap best, -1 if none does.
PN_INLINE int halving_arrival(const Arrivals& a, Floats start, Floats width)
{
    int best = -1;
    float best_score = LocalRules::least_turn;
    for (int k = 0; k < a.count; k += lane_count)
    {
        const Floats scores = halving(load<Floats>(a.angle + k), start, width);
        if (const Mask there = a.free[k / lane_count] & below(all(best_score), scores); there != 0)
        {
            const int lane = largest_lane(there, scores);
            best = k + lane;
            best_score = scores[lane];
        }
    }
    return best;
}

/// Whether a point lies within the distance of (x, y, z), all in the frame of the leaf.
PN_INLINE bool has_point_near(const LocalPoints& points, float x, float y, float z, float distance)
{
    Mask found = 0;
    for (int k = 0; k < points.count; k += lane_count)
    {
        const Floats dx = load<Floats>(points.x + k) - x, dy = load<Floats>(points.y + k) - y,
                     dz = load<Floats>(points.z + k) - z;
        found |= below(dx * dx + dy * dy + dz * dz, all(distance * distance));
    }
    return found != 0;
}
