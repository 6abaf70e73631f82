// What other translation units call. No include guard: see lanes.h.

void gather_rows_of_leaf(const RowsView& from, int leaf, int first_index, float scale, const float* offset,
                         const float* half_box, bool takes_all, LocalPoints& to)
{
    gather_rows(from, leaf, first_index, scale, offset, half_box, takes_all, to);
}

void make_fan(const LocalPoints& points, const Centre& c, std::int32_t* hits, int count, bool accurate, Ring& ring,
              Fan& fan)
{
    fill_ring(points, c, hits, count, ring);
    find_tangents(c, accurate, ring);
    sort_fan(ring, accurate, fan);
}

int find_near_points(const LocalPoints& points, const Centre& c, std::int32_t* found)
{
    return find_near(points, c, found);
}
