#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

/// Curves and triangles through points with normals (Guennebaud, Barthe, Paulin 2005, section 3), as the paper has
/// them. The filter computes the same many at a time (finish_kernel.h, ring_kernel.h, front_kernel.h); tests compare
/// both.
namespace recon
{

template <class T>
using Vec3 = Eigen::Matrix<T, 3, 1>;

/// A point and its unit normal.
template <class T>
struct PointNormal
{
    Vec3<T> position;
    Vec3<T> normal;
};

/// Tangent of the curve at p0: the third of the edge to p1 turned into p0's tangent plane, b210 - p0 (section 3). The
/// control point keeps its distance from p0, unlike Vlachos et al.'s. Zero if the edge is parallel to the normal.
template <class T>
inline Vec3<T> pn_tangent(const PointNormal<T>& p0, const Vec3<T>& p1)
{
    const Vec3<T> edge = p1 - p0.position;
    const Vec3<T> flat = edge - edge.dot(p0.normal) * p0.normal;
    const T squared = flat.squaredNorm();
    return squared > T(0) ? Vec3<T>(flat * (std::sqrt(edge.squaredNorm() / squared) / T(3))) : Vec3<T>(Vec3<T>::Zero());
}

/// The six tangents b - p of a PN triangle, each from its own corner.
template <class T>
struct PnTangents
{
    Vec3<T> t01, t02, t10, t12, t20, t21; ///< t01: at p0 towards p1.
};

template <class T>
inline PnTangents<T> pn_tangents(const PointNormal<T>& p0, const PointNormal<T>& p1, const PointNormal<T>& p2)
{
    return {pn_tangent(p0, p1.position), pn_tangent(p0, p2.position), pn_tangent(p1, p0.position),
            pn_tangent(p1, p2.position), pn_tangent(p2, p0.position), pn_tangent(p2, p1.position)};
}

/// Point of the patch at u = v = w = 1/3: the centroid moved by the mean of the six tangents (eq. 3).
template <class T>
inline Vec3<T> pn_centre(const Vec3<T>& p0, const Vec3<T>& p1, const Vec3<T>& p2, const PnTangents<T>& t)
{
    return (p0 + p1 + p2) / T(3) + (t.t01 + t.t02 + t.t10 + t.t12 + t.t20 + t.t21) / T(6);
}

/// Normal of the patch there, not normalised; counter-clockwise triangles give outward normals. The paper prints a
/// factor 7 before the edges; what follows from its eq. 1 is 1.
template <class T>
inline Vec3<T> pn_centre_normal(const Vec3<T>& p0, const Vec3<T>& p1, const Vec3<T>& p2, const PnTangents<T>& t)
{
    const Vec3<T> b210 = p0 + t.t01, b201 = p0 + t.t02, b120 = p1 + t.t10, b021 = p1 + t.t12, b102 = p2 + t.t20,
                  b012 = p2 + t.t21;
    const Vec3<T> u = (p1 - p0) + b120 - b102 + b012 - b210 + T(2) * (b021 - b201);
    const Vec3<T> v = (p2 - p0) + b102 - b120 + b021 - b201 + T(2) * (b012 - b210);
    return u.cross(v);
}

/// Point of the whole patch at (u, v, w), w = 1 - u - v belonging to p0 (eq. 1).
template <class T>
inline Vec3<T> pn_point(const PointNormal<T>& p0, const PointNormal<T>& p1, const PointNormal<T>& p2, T u, T v)
{
    const PnTangents<T> t = pn_tangents(p0, p1, p2);
    const T w = T(1) - u - v;
    const Vec3<T>&a = p0.position, &b = p1.position, &c = p2.position;
    const Vec3<T> b210 = a + t.t01, b201 = a + t.t02, b120 = b + t.t10, b021 = b + t.t12, b102 = c + t.t20,
                  b012 = c + t.t21;
    const Vec3<T> middle = (a + b + c) / T(3);
    const Vec3<T> mean = (b210 + b201 + b120 + b021 + b102 + b012) / T(6);
    const Vec3<T> b111 = middle + T(1.5) * (mean - middle);
    return a * (w * w * w) + b * (u * u * u) + c * (v * v * v) +
           T(3) * (b210 * (w * w * u) + b120 * (w * u * u) + b201 * (w * w * v) + b021 * (u * u * v) +
                   b102 * (w * v * v) + b012 * (u * v * v)) +
           b111 * (T(6) * u * v * w);
}

/// Point of the cubic curve between two point-normals at t in [0, 1]: the border of their PN triangle.
template <class T>
inline Vec3<T> pn_curve_point(const PointNormal<T>& p0, const PointNormal<T>& p1, T t)
{
    const T s = T(1) - t;
    const Vec3<T> b210 = p0.position + pn_tangent(p0, p1.position), b120 = p1.position + pn_tangent(p1, p0.position);
    return p0.position * (s * s * s) + b210 * (T(3) * s * s * t) + b120 * (T(3) * s * t * t) +
           p1.position * (t * t * t);
}

/// Length of the curve's control polygon (eq. 4).
template <class T>
inline T geodesic_distance(const PointNormal<T>& p0, const PointNormal<T>& p1)
{
    const Vec3<T> edge = p1.position - p0.position;
    return edge.norm() * (T(2) / T(3)) + (edge + pn_tangent(p1, p0.position) - pn_tangent(p0, p1.position)).norm();
}

/// Angle between two vectors [radians], accurate near 0 and pi; 0 if one is zero.
template <class T>
inline T angle_between(const Vec3<T>& a, const Vec3<T>& b)
{
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Angle under which the curve from p0 to p1 appears from `apex`: the sum over its control polygon (eq. 5) [radians].
template <class T>
inline T curved_angle(const Vec3<T>& apex, const PointNormal<T>& p0, const PointNormal<T>& p1)
{
    const Vec3<T> a = p0.position - apex, d = p1.position - apex;
    const Vec3<T> b = a + pn_tangent(p0, p1.position), c = d + pn_tangent(p1, p0.position);
    return angle_between(a, b) + angle_between(b, c) + angle_between(c, d);
}

/// Whether a curve between the two keeps the sense of their normals (not eq. 6): neighbours must.
template <class T>
inline bool is_consistent(const PointNormal<T>& p0, const PointNormal<T>& p1)
{
    const Vec3<T> edge = p1.position - p0.position;
    const T slope = (p0.normal + p1.normal).dot(edge), limit = T(1) + p0.normal.dot(p1.normal);
    return slope * slope <= limit * limit * edge.squaredNorm();
}

} // namespace recon
