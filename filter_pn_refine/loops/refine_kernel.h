// Refinement of the points of one leaf (section 5). No include guard: see lanes.h.

/// Whether the planes of the points around a place pass near it: the mean of their squared slopes, that is, of the
/// sines of the angles under which each sees the place above its plane, with weights that leave little but the nearest.
struct SlopeToPlanes
{
    Floats nearest, slopes = {}, weights = {};

    /// Begins with one point, (x, y, z) away.
    PN_INLINE SlopeToPlanes(float x, float y, float z, const float* n) : nearest(all(1e30f))
    {
        look(all(x), all(y), all(z), all(n[0]), all(n[1]), all(n[2]));
        slopes = select(1u, slopes, Floats{});
        weights = select(1u, weights, Floats{});
    }
    PN_INLINE void look(Floats dx, Floats dy, Floats dz, Floats nx, Floats ny, Floats nz)
    {
        const Floats d2 = dx * dx + dy * dy + dz * dz, height = dx * nx + dy * ny + dz * nz;
        const Floats d4 = d2 * d2, weight = 1 / (d4 * d4 + 1e-36f);
        nearest = smaller(nearest, d2);
        slopes += weight * (height * height / (d2 + 1e-36f));
        weights += weight;
    }
    PN_INLINE bool is_nearer_than(float distance) const { return below(nearest, all(distance * distance)) != 0; }
    PN_INLINE bool is_steep() const
    {
        return sum_of(slopes - (LocalRules::largest_slope * LocalRules::largest_slope) * weights) > 0;
    }
};

struct PointRefiner
{
    const RefineStep& step;
    Workspace& w;
    LeafChildren& children;
    int leaf;
    float spacing = 0;                       ///< Usual distance between points around the refined one [radii].
    float least_distance = 0;                ///< To any point [radii].
    bool sees_all = true;                    ///< Ring and arrivals hold all points within the radius.
    static constexpr float hair = 1 + 1e-5f; ///< Comparisons are closed.

    /// N' begins with the old and new points nearer than lambda_1.
    PN_INLINE void start_front(const Centre& c, const Ring& ring, Arrivals& a, Front& f)
    {
        const Floats near = all(LocalRules::near);
        f.dead = 0;
        f.farthest = 0;
        if (ring.count <= lane_count && a.count <= lane_count)
        {
            const Mask old = at_most(load<Floats>(ring.length), near) & first_lanes(ring.count);
            const Mask fresh = a.count > 0 ? at_most(load<Floats>(a.length), near) & a.free[0] : 0;
            const int n_old = count_of(old), n = n_old + count_of(fresh);
            if (n <= lane_count)
            {
                const Ints entries = select(first_lanes(n_old), compress(old, lane_numbers),
                                            permute(compress(fresh, lane_numbers + lane_count), lane_numbers - n_old));
                const Ints order =
                    order_of(first_lanes(n), permute(load<Floats>(ring.angle), entries, load<Floats>(a.angle)));
                take_entries(ring, a, permute(entries, order), f);
                f.count = n;
                if (a.count > 0)
                {
                    store(a.reach, select(fresh, load<Floats>(a.near_reach), load<Floats>(a.reach)));
                    a.free[0] &= ~fresh;
                }
                return;
            }
        }
        start_crowded_front(c, ring, a, f);
    }

    /// The same for more than a vector holds: the nearest in each sector are enough to find gaps, but all are in reach.
    void start_crowded_front(const Centre& c, const Ring& ring, Arrivals& a, Front& f)
    {
        alignas(64) float angles[2 * ring_capacity], lengths[2 * ring_capacity], kept_angles[lane_count];
        std::int32_t entries[2 * ring_capacity]; // of the arrivals from ring_capacity on
        int n = 0;
        for (int k = 0; k < ring.count; k += lane_count)
        {
            const Mask near =
                at_most(load<Floats>(ring.length + k), all(LocalRules::near)) & first_lanes(ring.count - k);
            store_compressed(near, load<Floats>(ring.angle + k), angles + n);
            store_compressed(near, load<Floats>(ring.length + k), lengths + n);
            store_compressed(near, lane_numbers + k, entries + n);
            n += count_of(near);
        }
        for (int k = 0; k < a.count; k += lane_count)
        {
            const Mask near = at_most(load<Floats>(a.length + k), all(LocalRules::near)) & a.free[k / lane_count];
            store_compressed(near, load<Floats>(a.angle + k), angles + n);
            store_compressed(near, load<Floats>(a.length + k), lengths + n);
            store_compressed(near, lane_numbers + (ring_capacity + k), entries + n);
            store(a.reach + k, select(near, load<Floats>(a.near_reach + k), load<Floats>(a.reach + k)));
            a.free[k / lane_count] &= ~near;
            n += count_of(near);
        }
        const auto member_of = [&](int entry)
        { return entry >= ring_capacity ? a.source[entry - ring_capacity] | new_member : ring.source[entry]; };
        const float* kept = angles;
        if (n > lane_count)
        {
            f.farthest = *std::max_element(lengths, lengths + n);
            for (int k = 0; k < n; ++k)
                raise_radius(member_of(entries[k]), std::min(lengths[k] * hair, LocalRules::shrink) / c.inverse_radius);
            n = thin_to_sectors(angles, lengths, entries, n, kept_angles);
            kept = kept_angles;
        }
        const Ints order = order_of(first_lanes(n), load<Floats>(kept));
        f.count = n;
        for (int k = 0; k < n; ++k)
        {
            const int entry = entries[order[k]], i = entry % ring_capacity;
            const bool is_new = entry >= ring_capacity;
            f.angle[k] = kept[order[k]];
            f.x[k] = is_new ? a.x[i] : ring.x[i];
            f.y[k] = is_new ? a.y[i] : ring.y[i];
            f.z[k] = is_new ? a.z[i] : ring.z[i];
            f.nx[k] = is_new ? a.nx[i] : ring.nx[i];
            f.ny[k] = is_new ? a.ny[i] : ring.ny[i];
            f.nz[k] = is_new ? a.nz[i] : ring.nz[i];
            f.member[k] = member_of(entry);
        }
    }

    /// Lets an arrival join N'.
    PN_INLINE void join_arrival(int k, bool curved, Front& f)
    {
        Arrivals& a = w.arrivals;
        a.free[k / lane_count] &= ~(1u << k % lane_count);
        a.reach[k] = a.near_reach[k];
        join({a.angle[k], a.x[k], a.y[k], a.z[k], a.nx[k], a.ny[k], a.nz[k], a.source[k] | new_member}, curved, f);
    }

    /// Whether a new point may not lie at (x, y, z): nearer than `least` to an old or a new point, inside the discard
    /// space, or far above or below the planes of its nearest points.
    PN_INLINE bool is_discarded(const Centre& c, float x, float y, float z, float least) const
    {
        const Ring& ring = w.ring;
        const Arrivals& a = w.arrivals;
        SlopeToPlanes planes(x, y, z, c.n);
        for (int k = 0; k < ring.count; k += lane_count)
            planes.look(load<Floats>(ring.x + k) - x, load<Floats>(ring.y + k) - y, load<Floats>(ring.z + k) - z,
                        load<Floats>(ring.nx + k), load<Floats>(ring.ny + k), load<Floats>(ring.nz + k));
        if (planes.is_nearer_than(least) || planes.is_steep())
            return true;
        Mask bad = 0;
        for (int k = 0; k < a.count; k += lane_count)
        {
            const Floats dx = load<Floats>(a.x + k) - x, dy = load<Floats>(a.y + k) - y, dz = load<Floats>(a.z + k) - z,
                         reach = larger(load<Floats>(a.reach + k), all(least));
            bad |= below(dx * dx + dy * dy + dz * dz, reach * reach) & first_lanes(a.count - k);
        }
        if (bad != 0 || sees_all)
            return bad != 0;
        const float r = 1 / c.inverse_radius;
        x = x * r + c.x;
        y = y * r + c.y;
        z = z * r + c.z;
        return has_point_near(w.old_points, x, y, z, least_distance * r) ||
               has_point_near(w.new_points, x, y, z, least_distance * r);
    }

    /// Gaps of N' that are large against the spacing, though perhaps narrower than theta_c.
    PN_INLINE Mask large_gaps(const Front& f, Floats squared, Floats plane) const
    {
        const float most = 2 * LocalRules::large_gap * spacing * step.shrinking;
        return below(all(most * most), squared) & below(all(2 * LocalRules::least_turn), plane) & first_lanes(f.count);
    }

    /// Whether N' has gaps to fill.
    PN_INLINE bool is_incomplete(const Front& f, Floats plane, Floats gaps) const
    {
        return f.count < lane_count &&
               ((below(all(LocalRules::complete_angle), gaps) & first_lanes(std::max(f.count, 1))) != 0 ||
                (f.count > 2 && large_gaps(f, squared_diameters(f), plane) != 0));
    }

    /// Fills the gaps of N' wider than theta_c. \returns true if one stays open.
    PN_INLINE bool fill_gaps(const Centre& c, int own, bool curved, Floats plane, Floats gaps, Front& f)
    {
        Candidates& candidates = w.candidates;
        bool is_open = false;
        while (f.count < lane_count)
        {
            const Mask wide =
                below(all(LocalRules::complete_angle), gaps) & first_lanes(std::max(f.count, 1)) & ~f.dead;
            if (wide == 0)
            {
                fill_large_gaps(c, own, curved, f);
                return is_open;
            }
            const int widest = largest_lane(wide, gaps);
            const Floats start = f.count > 0 ? permute(f.angle, all(widest)) : Floats{},
                         width = permute(plane, all(widest));
            // The candidate in the gap's sector that halves it best.
            const Floats score = halving(load<Floats>(candidates.angle), start, width);
            if (const Mask fitting = candidates.usable & below(all(LocalRules::least_turn), score); fitting != 0)
            {
                const int best = largest_lane(fitting, score);
                candidates.usable &= ~(1u << best);
                const float x = candidates.x[best], y = candidates.y[best], z = candidates.z[best];
                if (!is_discarded(c, x, y, z, least_distance))
                {
                    if (w.arrivals.count >= ring_capacity)
                        continue;
                    join(insert(c, own, best), curved, f);
                }
                else
                {
                    // The nearest of the new points in this gap takes its place.
                    const int nearest = nearest_arrival(w.arrivals, start, width, x, y, z);
                    if (nearest < 0)
                        continue;
                    join_arrival(nearest, curved, f);
                }
            }
            else if (const int best = halving_arrival(w.arrivals, start, width); best >= 0)
                join_arrival(best, curved, f);
            else
            {
                is_open = true;
                f.dead |= 1u << widest;
                continue;
            }
            plane = plane_gaps(f);
            gaps = measure_gaps(f, plane, curved);
        }
        return is_open;
    }

    /// Inserts into gaps of N' that are narrow enough but large (LocalRules::large_gap).
    PN_INLINE void fill_large_gaps(const Centre& c, int own, bool curved, Front& f)
    {
        Candidates& candidates = w.candidates;
        Mask hopeless = 0;
        while (f.count > 2 && f.count < lane_count && w.arrivals.count < ring_capacity)
        {
            const Floats squared = squared_diameters(f), plane = plane_gaps(f);
            const Mask large = large_gaps(f, squared, plane) & ~hopeless;
            if (large == 0)
                return;
            const int widest = largest_lane(large, squared);
            const Floats score =
                halving(load<Floats>(candidates.angle), permute(f.angle, all(widest)), permute(plane, all(widest)));
            const Mask fitting = candidates.usable & candidates.firm & below(all(LocalRules::least_turn), score);
            if (fitting == 0)
            {
                hopeless |= 1u << widest;
                continue;
            }
            const int best = largest_lane(fitting, score);
            candidates.usable &= ~(1u << best);
            if (is_discarded(c, candidates.x[best], candidates.y[best], candidates.z[best], LocalRules::free * spacing))
                continue;
            join(insert(c, own, best), curved, f);
            hopeless = 0;
        }
    }

    /// Makes a candidate a new point.
    PN_INLINE NewMember insert(const Centre& c, int own, int candidate)
    {
        Arrivals& a = w.arrivals;
        const Candidates& from = w.candidates;
        const int next = candidate + 1 < w.fan.count ? candidate + 1 : 0;
        const float radius = 1 / c.inverse_radius, unit = float(1 / w.scale);
        const float x = from.x[candidate], y = from.y[candidate], z = from.z[candidate];
        const float nx = from.nx[candidate], ny = from.ny[candidate], nz = from.nz[candidate];
        const float own_radius = std::min(__builtin_sqrtf(x * x + y * y + z * z), LocalRules::shrink);
        LocalPoints& to = w.new_points;
        to.reserve(to.count + 1);
        const int j = to.count++;
        if (j % lane_count == 0) // a new vector is begun
            to.pad(j + 1);
        to.x[j] = x * radius + c.x;
        to.y[j] = y * radius + c.y;
        to.z[j] = z * radius + c.z;
        to.nx[j] = nx;
        to.ny[j] = ny;
        to.nz[j] = nz;
        to.radius[j] = own_radius * radius;
        to.largest_radius[j] = LocalRules::shrink * radius;
        to.leaf[j] = leaf;
        to.index[j] = children.count();
        const auto level_place = [&](int entry) { return w.old_points.index[w.ring.source[entry]]; };
        children.append({w.old_points.index[own], level_place(w.fan.entry[candidate]), level_place(w.fan.entry[next])},
                        {to.x[j] * unit, to.y[j] * unit, to.z[j] * unit, nx, ny, nz, to.radius[j] * unit,
                         to.largest_radius[j] * unit});
        // It belongs to N', so only what keeps others away from it matters. Whole vectors are written, since they are
        // read at once.
        const int k = a.count++, first = k & ~(lane_count - 1);
        if (k == first)
            a.free[k / lane_count] = 0;
        const auto put = [&](float* values, float value)
        { store(values + first, select(1u << (k - first), all(value), load<Floats>(values + first))); };
        put(a.x, x);
        put(a.y, y);
        put(a.z, z);
        put(a.reach, std::max(LocalRules::discard_near * own_radius, least_distance));
        return {from.angle[candidate], x, y, z, nx, ny, nz, j | new_member};
    }

    /// Raises the radius of a member of N' to this.
    PN_INLINE void raise_radius(int member, float radius)
    {
        const int source = member & ~new_member;
        const LocalPoints& points = member & new_member ? w.new_points : w.old_points;
        float* const raised = (member & new_member ? w.new_points.radius : w.next.data()) + source;
        // Nor may a point with a large radius, at the rim of a hole, raise those of all others around it.
        *raised = std::max(*raised, std::min(radius, points.largest_radius[source]));
    }

    /// Per gap of N' the square of the radius that shows what lies across it, 0 where that is no question.
    PN_INLINE Floats squared_sights(const Front& f) const
    {
        if (f.count < 3)
            return Floats{};
        const float most = 2 * LocalRules::seen_gap * spacing, limit = LocalRules::seen_most * spacing;
        const Floats squared = squared_diameters(f), plane = plane_gaps(f);
        // The circles of very narrow gaps and of half turns say nothing.
        const Mask large = below(all(most * most), squared) & below(all(2 * LocalRules::least_turn), plane) &
                           below(plane, all(3.f)) & first_lanes(f.count);
        return select(large, smaller(squared, all(limit * limit)), Floats{});
    }

    PN_INLINE void write_radii(int own, const Centre& c, bool is_open, const Front& f)
    {
        const float least = std::max(is_open ? LocalRules::open_radius : 0, f.farthest);
        float radius2 = least * least, sight2 = 0;
        const float radius = 1 / c.inverse_radius;
        if (const int n = f.count; n > 0)
        {
            const Ints next = successors(n), previous = select(1u, all(n - 1), lane_numbers - 1);
            const Floats d2 = select(first_lanes(n), f.x * f.x + f.y * f.y + f.z * f.z, Floats{});
            const Floats dx = permute(f.x, next) - f.x, dy = permute(f.y, next) - f.y, dz = permute(f.z, next) - f.z;
            const Floats sights = squared_sights(f);
            // What lies across a gap must be seen from both its ends as well.
            const Floats after = larger(select(~f.dead & 0xFFFFu, dx * dx + dy * dy + dz * dz, Floats{}), sights);
            const Floats reach2 = larger(d2, larger(after, permute(after, previous)));
            alignas(64) float raised[lane_count];
            alignas(64) std::int32_t members[lane_count];
            store(raised, smaller(root(reach2) * hair, all(LocalRules::shrink)) * radius);
            store(members, f.member);
            for (int k = 0; k < n; ++k)
                raise_radius(members[k], raised[k]);
            radius2 = std::max(radius2, largest(d2));
            sight2 = largest(sights);
        }
        float& own_next = w.next[std::size_t(own)];
        const float most = is_open ? LocalRules::open_radius : LocalRules::shrink;
        const float reach = std::max(std::min(__builtin_sqrtf(radius2) * hair, most),
                                     std::min(__builtin_sqrtf(sight2), LocalRules::seen_growth));
        own_next = std::max(own_next, reach * radius);
    }

    PN_INLINE bool refine(int own)
    {
        const LocalPoints& old_points = w.old_points;
        Centre c{old_points.x[own],
                 old_points.y[own],
                 old_points.z[own],
                 {old_points.nx[own], old_points.ny[own], old_points.nz[own]},
                 {},
                 {},
                 1 / old_points.radius[own]};
        set_tangents(c);
        const WorkPoint& point = step.level.points[std::size_t(old_points.index[own])];
        spacing = point.spacing * step.spacing_ratio * float(w.scale) * c.inverse_radius;
        least_distance = std::max(LocalRules::least_distance, LocalRules::least_spacings * spacing);
        Ring& ring = w.ring;
        std::int32_t* hits = w.hits.data();
        const int found_old = find_near(old_points, c, hits);
        int found = found_old;
        // Far from creases normals of neighbours may differ as much as elsewhere.
        const bool at_crease = w.has_creases && std::any_of(hits, hits + found_old,
                                                            [&](int j) { return w.is_crease[std::size_t(j)] != 0; });
        const FaceSector own_face = w.has_creases ? w.faces[std::size_t(own)] : FaceSector{};
        if (found > largest_ring || at_crease)
            found = choose_hits(old_points, c, step.least_crease_agreement, at_crease, own_face, w.faces, hits, found);
        fill_ring(old_points, c, hits, found, ring);
        bool accurate = step.precision == Precision::accurate || step.precision == Precision::fuzzy;
        if (step.precision == Precision::automatic)
        {
            Mask bent = 0;
            for (int k = 0; k < ring.count; k += lane_count)
                bent |= below(load<Floats>(ring.flatness + k), all(LocalRules::curved_below));
            accurate = bent != 0;
        }
        found = find_near(w.new_points, c, hits);
        sees_all = ring.count == found_old && found <= largest_ring;
        if (found > largest_ring)
            found = choose_hits(w.new_points, c, 0, false, own_face, w.faces, hits, found);
        fill_arrivals(w.new_points, c, hits, found, spacing, least_distance, w.arrivals);
        if (at_crease)
            reject_other_side(w, c, own_face, step.least_crease_agreement, least_distance);
        Front front;
        start_front(c, ring, w.arrivals, front);
        const Floats plane = front.count > 0 ? plane_gaps(front) : all(6.28318531f);
        const Floats gaps = front.count > 0 ? measure_gaps(front, plane, accurate) : plane;
        bool is_open = false, is_rim = false;
        // Every third point finds its neighbourhood complete: the points before have seen to that.
        if (is_incomplete(front, plane, gaps))
        {
            const bool in_plane = accurate && step.precision != Precision::fuzzy;
            find_tangents(c, in_plane, ring);
            sort_fan(ring, in_plane, w.fan);
            const float fan_gap = list_candidates(c, ring, w.fan, least_distance, spacing, w.candidates);
            if (w.has_creases)
                reject_behind_edges(w, c);
            if (point.flags & WorkPoint::near_mouth)
                reject_in_mouths(w, c, *step.mouths, double(point.spacing));
            is_open = fill_gaps(c, own, accurate, plane, gaps, front);
            // A rim stays open: keeping the radius large there would only collect neighbours.
            is_rim = fan_gap > step.boundary_angle;
        }
        const bool is_large = LocalRules::largest_open * spacing < 1;
        write_radii(own, c, is_open && !is_rim && !is_large, front);
        return is_open;
    }
};

int refine_points_of_leaf(const RefineStep& step, Workspace& w, int self)
{
    PointRefiner refiner{step, w, step.children[std::size_t(self)], self};
    const Leaf& leaf = step.level.leaves[std::size_t(self)];
    int open = 0;
    for (int i = 0; i < leaf.size(); ++i)
    {
        w.hits.resize(std::size_t(std::max(w.old_points.count, w.new_points.count)) + 2 * lane_count);
        if (step.level.points[std::size_t(leaf.begin + i)].flags & WorkPoint::refined)
            open += refiner.refine(i);
    }
    return open;
}
