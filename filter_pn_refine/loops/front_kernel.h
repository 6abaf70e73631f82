// N', the new neighbourhood of a point (section 5), and its gaps. No include guard: see lanes.h.

/// A PN tangent: the third of the edge turned into the plane of n.
PN_INLINE void add_tangent(Floats ex, Floats ey, Floats ez, Floats nx, Floats ny, Floats nz, Floats& x, Floats& y,
                           Floats& z)
{
    const Floats d2 = ex * ex + ey * ey + ez * ez, s = ex * nx + ey * ny + ez * nz;
    const Floats flat = larger(d2 - s * s, 1e-6f * d2 + 1e-30f);
    const Floats g = root(d2) * inverse_root(flat) * (1.f / 3);
    x += (ex - s * nx) * g;
    y += (ey - s * ny) * g;
    z += (ez - s * nz) * g;
}

constexpr int new_member = 1 << 24; ///< Marks new points among the members of N'.

/// N', sorted by angle, in the frame of the refined point. Members are local points.
struct Front
{
    int count;
    Mask dead;      ///< Gaps that nothing can fill.
    float farthest; ///< [radii] Of more members than the vectors hold.
    Floats angle, x, y, z, nx, ny, nz;
    Ints member;
};
struct NewMember
{
    float angle, x, y, z, nx, ny, nz;
    int member;
};

/// Members from the first vectors of the ring and (16 and more) of the arrivals.
PN_INLINE void take_entries(const Ring& ring, const Arrivals& a, Ints entries, Front& f)
{
    const auto take = [&](const float* p, const float* q)
    { return permute(load<Floats>(p), entries, load<Floats>(q)); };
    f.angle = take(ring.angle, a.angle);
    f.x = take(ring.x, a.x);
    f.y = take(ring.y, a.y);
    f.z = take(ring.z, a.z);
    f.nx = take(ring.nx, a.nx);
    f.ny = take(ring.ny, a.ny);
    f.nz = take(ring.nz, a.nz);
    f.member = permute(load<Ints>(ring.source), entries, load<Ints>(a.source) | new_member);
}

/// Gaps of N' in the tangent plane.
PN_INLINE Floats plane_gaps(const Front& f)
{
    return permute(f.angle, successors(f.count)) - f.angle + select(1u << (f.count - 1), all(6.28318531f), Floats{});
}

/// Squared diameters of the circles through the centre and two members that follow each other.
PN_INLINE Floats squared_diameters(const Front& f)
{
    const Ints next = successors(f.count);
    const Floats bx = permute(f.x, next), by = permute(f.y, next), bz = permute(f.z, next);
    const Floats ex = bx - f.x, ey = by - f.y, ez = bz - f.z;
    const Floats cx = f.y * bz - f.z * by, cy = f.z * bx - f.x * bz, cz = f.x * by - f.y * bx;
    const Floats a2 = f.x * f.x + f.y * f.y + f.z * f.z;
    // The product of the sides over twice the area.
    return a2 * permute(a2, next) * (ex * ex + ey * ey + ez * ez) / (cx * cx + cy * cy + cz * cz + 1e-20f);
}

/// The angles that the curves between them sweep (eq. 5), where that matters.
PN_INLINE Floats measure_gaps(const Front& f, Floats plane, bool curved)
{
    // The curve bends an angle by far less than what lies outside these limits.
    const Mask unsure = at_most(all(0.9f), plane) & at_most(plane, all(2.6f)) & first_lanes(f.count);
    if (!curved || unsure == 0)
        return plane;
    const Ints next = successors(f.count);
    const Floats bx = permute(f.x, next), by = permute(f.y, next), bz = permute(f.z, next);
    const Floats ex = bx - f.x, ey = by - f.y, ez = bz - f.z;
    Floats cx = f.x, cy = f.y, cz = f.z, dx = bx, dy = by, dz = bz;
    add_tangent(ex, ey, ez, f.nx, f.ny, f.nz, cx, cy, cz);
    add_tangent(-ex, -ey, -ez, permute(f.nx, next), permute(f.ny, next), permute(f.nz, next), dx, dy, dz);
    const auto angle = [](Floats px, Floats py, Floats pz, Floats qx, Floats qy, Floats qz)
    {
        const Floats rx = py * qz - pz * qy, ry = pz * qx - px * qz, rz = px * qy - py * qx;
        return angle_of(px * qx + py * qy + pz * qz, root(rx * rx + ry * ry + rz * rz));
    };
    const Floats swept =
        angle(f.x, f.y, f.z, cx, cy, cz) + angle(cx, cy, cz, dx, dy, dz) + angle(dx, dy, dz, bx, by, bz);
    return select(unsure, swept, plane);
}

/// Puts a point into N' where its angle belongs.
PN_INLINE void join(const NewMember& m, bool curved, Front& f)
{
    const int n = f.count;
    const int at = count_of(at_most(f.angle, all(m.angle)) & first_lanes(n));
    const Mask lane = 1u << at, lower = lane - 1;
    const Ints places = lane_numbers + select(lower, Ints{}, all(-1));
    const auto put = [&](Floats& values, float value) { values = select(lane, all(value), permute(values, places)); };
    put(f.angle, m.angle);
    put(f.x, m.x);
    put(f.y, m.y);
    put(f.z, m.z);
    if (curved)
    {
        put(f.nx, m.nx);
        put(f.ny, m.ny);
        put(f.nz, m.nz);
    }
    f.member = select(lane, all(m.member), permute(f.member, places));
    f.count = n + 1;
    f.dead = ((f.dead & lower) | (f.dead & ~lower) << 1) & ~(lane | 1u << (at == 0 ? n : at - 1));
}

/// How well directions halve the gap: the smaller of the two parts.
PN_INLINE Floats halving(Floats angle, Floats start, Floats width)
{
    Floats t = angle - start;
    t = where_below(t, Floats{}, t + 6.28318531f, t);
    return smaller(t, width - t);
}
