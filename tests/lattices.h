#pragma once

#include "shapes.h"

#include <recon/geometry.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace shapes
{

/// The points of a lattice through the origin that are nearest to some points, each once.
inline recon::Points rounded(recon::Points points, const recon::Vector& steps)
{
    for (recon::Point& p : points)
        p = (p.array() / steps.array()).round() * steps.array();
    const auto is_before = [](const recon::Point& a, const recon::Point& b)
    { return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3); };
    std::sort(points.begin(), points.end(), is_before);
    points.erase(std::unique(points.begin(), points.end()), points.end());
    return points;
}

/// Voxels of half a torus, open at both ends: planes of the lattice lie beside each other there as walls do.
inline recon::Points half_torus_on_lattice()
{
    recon::Points half;
    for (const recon::Point& p : torus(60000, 1, 0.4, 4).points)
        if (p.dot(recon::Vector(1, 0.4, 0.7)) < 0)
            half.push_back(p);
    return rounded(half, recon::Vector::Constant(0.06));
}

/// All points of a lattice on the faces of a cube, a side of so many steps of length 1.
inline recon::Points lattice_cube(int side)
{
    recon::Points points;
    for (int x = 0; x <= side; ++x)
        for (int y = 0; y <= side; ++y)
            for (int z = 0; z <= side; ++z)
                if (x % side == 0 || y % side == 0 || z % side == 0)
                    points.emplace_back(x, y, z);
    return points;
}

} // namespace shapes
