#pragma once

#include <algorithm>
#include <cmath>

namespace recon
{

/// Weighted point of a regular triangulation; weight = squared radius of its ball, 0 in a Delaunay triangulation.
struct alignas(32) Site
{
    double x, y, z, weight;
};

/// The same two signs by exact arithmetic (CGAL), for what doubles leave open.
int find_orientation_exactly(const Site& a, const Site& b, const Site& c, const Site& d);
int find_power_side_exactly(const Site& a, const Site& b, const Site& c, const Site& d, const Site& e);

/// Sign of det(b - a, c - a, d - a): +1 if a, b, c, d are positively oriented, 0 if they are coplanar. Exact.
inline int find_orientation(const Site& a, const Site& b, const Site& c, const Site& d)
{
    const double bx = b.x - a.x, by = b.y - a.y, bz = b.z - a.z;
    const double cx = c.x - a.x, cy = c.y - a.y, cz = c.z - a.z;
    const double dx = d.x - a.x, dy = d.y - a.y, dz = d.z - a.z;
    const double determinant = bx * (cy * dz - cz * dy) - by * (cx * dz - cz * dx) + bz * (cx * dy - cy * dx);
    const double x = std::max({std::abs(bx), std::abs(cx), std::abs(dx)});
    const double y = std::max({std::abs(by), std::abs(cy), std::abs(dy)});
    const double z = std::max({std::abs(bz), std::abs(cz), std::abs(dz)});
    // Six products of three factors with some seven roundings each.
    const double error = 6e-15 * x * y * z;
    if (std::abs(determinant) > error && error > 1e-280)
        return determinant > 0 ? 1 : -1;
    return find_orientation_exactly(a, b, c, d);
}

/// Side of e on the sphere orthogonal to a, b, c, d, which are positively oriented: +1 if a regular triangulation that
/// contains e does not contain their cell (with equal weights: e lies inside the circumsphere), 0 on it. Exact.
inline int find_power_side(const Site& a, const Site& b, const Site& c, const Site& d, const Site& e)
{
    const double ax = a.x - e.x, ay = a.y - e.y, az = a.z - e.z, aw = e.weight - a.weight;
    const double bx = b.x - e.x, by = b.y - e.y, bz = b.z - e.z, bw = e.weight - b.weight;
    const double cx = c.x - e.x, cy = c.y - e.y, cz = c.z - e.z, cw = e.weight - c.weight;
    const double dx = d.x - e.x, dy = d.y - e.y, dz = d.z - e.z, dw = e.weight - d.weight;
    const double a2 = ax * ax + ay * ay + az * az, b2 = bx * bx + by * by + bz * bz;
    const double c2 = cx * cx + cy * cy + cz * cz, d2 = dx * dx + dy * dy + dz * dz;
    const double ab = ax * by - bx * ay, bc = bx * cy - cx * by, cd = cx * dy - dx * cy;
    const double da = dx * ay - ax * dy, ac = ax * cy - cx * ay, bd = bx * dy - dx * by;
    const double abc = az * bc - bz * ac + cz * ab, bcd = bz * cd - cz * bd + dz * bc;
    const double cda = cz * da + dz * ac + az * cd, dab = dz * ab + az * bd + bz * da;
    const double determinant = ((c2 + cw) * dab - (d2 + dw) * abc) + ((a2 + aw) * bcd - (b2 + bw) * cda);
    const double x = std::max({std::abs(ax), std::abs(bx), std::abs(cx), std::abs(dx)});
    const double y = std::max({std::abs(ay), std::abs(by), std::abs(cy), std::abs(dy)});
    const double z = std::max({std::abs(az), std::abs(bz), std::abs(cz), std::abs(dz)});
    const double t = std::max({a2 + std::abs(aw), b2 + std::abs(bw), c2 + std::abs(cw), d2 + std::abs(dw)});
    // 24 products of four factors with some fifteen roundings each make 4e-14; twice that for safety.
    const double error = 1e-13 * x * y * z * t;
    if (std::abs(determinant) > error && error > 1e-280)
        return determinant > 0 ? 1 : -1;
    return find_power_side_exactly(a, b, c, d, e);
}

} // namespace recon
