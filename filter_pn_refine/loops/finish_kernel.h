// New points in double. No include guard: see lanes.h.

struct Vector3s
{
    Doubles x, y, z;
};
PN_INLINE Vector3s operator+(const Vector3s& a, const Vector3s& b)
{
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
PN_INLINE Vector3s operator-(const Vector3s& a, const Vector3s& b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
PN_INLINE Vector3s operator*(const Vector3s& a, Doubles s)
{
    return {a.x * s, a.y * s, a.z * s};
}
PN_INLINE Doubles dot(const Vector3s& a, const Vector3s& b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
PN_INLINE Vector3s cross(const Vector3s& a, const Vector3s& b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// pn_tangent() of pn_triangle.h.
PN_INLINE Vector3s tangent(const Vector3s& p, const Vector3s& n, const Vector3s& q)
{
    const Vector3s edge = q - p;
    const Vector3s flat = edge - n * dot(edge, n);
    const Doubles squared = dot(flat, flat), zero = {};
    const Doubles scale = root(dot(edge, edge) / (squared > zero ? squared : zero + 1)) / 3;
    return flat * scale;
}

/// Positions, normals and ids of parents of the new points of triangles, `corners` being places among `points`.
void finish_children(const WorkPoint* points, const std::array<int, 3>* corners, int count, WorkPoint* out,
                     std::array<int, 3>* parents)
{
    for (int first = 0; first < count; first += doubles_count)
    {
        const int n = std::min(count - first, doubles_count);
        alignas(64) double in[3][6][doubles_count];
        for (int k = first + doubles_count; k < std::min(count, first + 2 * doubles_count); ++k)
            for (int place : corners[k])
                __builtin_prefetch(points + place);
        for (int k = 0; k < doubles_count; ++k)
        {
            const std::array<int, 3>& corner = corners[first + std::min(k, n - 1)];
            for (int m = 0; m < 3; ++m)
            {
                const WorkPoint& p = points[corner[std::size_t(m)]];
                const double *position = p.position.data(), *normal = p.normal.data();
                for (int d = 0; d < 3; ++d)
                {
                    in[m][d][k] = position[d];
                    in[m][3 + d][k] = normal[d];
                }
                if (k < n)
                    parents[first + k][std::size_t(m)] = p.id;
            }
        }
        const auto position = [&](int m) {
            return Vector3s{load<Doubles>(in[m][0]), load<Doubles>(in[m][1]), load<Doubles>(in[m][2])};
        };
        const auto normal = [&](int m) {
            return Vector3s{load<Doubles>(in[m][3]), load<Doubles>(in[m][4]), load<Doubles>(in[m][5])};
        };
        const Vector3s p0 = position(0), p1 = position(1), p2 = position(2);
        const Vector3s n0 = normal(0), n1 = normal(1), n2 = normal(2);
        const Vector3s t01 = tangent(p0, n0, p1), t02 = tangent(p0, n0, p2), t10 = tangent(p1, n1, p0),
                       t12 = tangent(p1, n1, p2), t20 = tangent(p2, n2, p0), t21 = tangent(p2, n2, p1);
        const Doubles one = Doubles{} + 1;
        // From p0, so that no digits are lost far from the origin.
        const Vector3s e1 = p1 - p0, e2 = p2 - p0;
        const Vector3s centre = p0 + (e1 + e2) * (one / 3) + (t01 + t02 + t10 + t12 + t20 + t21) * (one / 6);
        // pn_centre_normal() relative to p0.
        const Vector3s b120 = e1 + t10, b021 = e1 + t12, b102 = e2 + t20, b012 = e2 + t21;
        const Vector3s u = e1 + b120 - b102 + b012 - t01 + (b021 - t02) * (one + one);
        const Vector3s v = e2 + b102 - b120 + b021 - t02 + (b012 - t01) * (one + one);
        const Vector3s made = cross(u, v), sum = n0 + n1 + n2;
        const Vector3s mean = sum * (one / root(dot(sum, sum)));
        const Doubles length = root(dot(made, made)), zero = {};
        // A patch that folds tells less than its corners.
        const auto takes = (length > zero) & (dot(made, mean) >= 0.5 * length);
        const Doubles scale = one / (takes ? length : one);
        const Vector3s unit = {takes ? made.x * scale : mean.x, takes ? made.y * scale : mean.y,
                               takes ? made.z * scale : mean.z};
        for (int k = 0; k < n; ++k)
        {
            const std::array<int, 3>& corner = corners[first + k];
            out[first + k].spacing =
                (points[corner[0]].spacing + points[corner[1]].spacing + points[corner[2]].spacing) * (1.f / 3);
            out[first + k].position = Point(centre.x[k], centre.y[k], centre.z[k]);
            out[first + k].normal = Vector(unit.x[k], unit.y[k], unit.z[k]);
        }
    }
}
