#pragma once

#include "tests/shapes.h"

#include <recon/geometry.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <vector>

namespace benchmarks
{

/// Points uniform in area.
class AreaSampler
{
public:
    AreaSampler(const recon::TriangleMesh& mesh, unsigned seed) : mesh_(mesh), random_(seed)
    {
        double sum = 0;
        for (const auto& t : mesh.triangles)
            sums_.push_back(sum += 0.5 * side(t, 1).cross(side(t, 2)).norm());
    }
    double area() const { return sums_.back(); }
    recon::Point draw()
    {
        const auto at = std::lower_bound(sums_.begin(), sums_.end() - 1, uniform() * area());
        const auto& t = mesh_.triangles[std::size_t(at - sums_.begin())];
        const double a = std::sqrt(uniform()), b = uniform();
        return mesh_.vertices[t[0]] + a * (1 - b) * side(t, 1) + a * b * side(t, 2);
    }

private:
    double uniform() { return shapes::uniform(random_); }
    recon::Vector side(const std::array<int, 3>& t, int k) const { return mesh_.vertices[t[k]] - mesh_.vertices[t[0]]; }

    const recon::TriangleMesh& mesh_;
    shapes::Random random_;
    std::vector<double> sums_;
};

} // namespace benchmarks
