#pragma once

#include <recon/geometry.h>

#include <vector>

namespace recon
{

/// Plane that a part of a noisy cloud lies in.
struct NoisyPlane
{
    Point origin;
    Vector normal; ///< Of unit length.

    double height(const Point& p) const { return normal.dot(p - origin); }
};

/// Half the thickness of what noise makes of a plane, and how far off what it leaves bare begins [noise].
constexpr double slab_half = 2.5, beside_slab = 3.5;

/// Standard deviation of the heights in the slab up to which they are more likely a plane's than spread evenly, as
/// those of any slab through a body are: where exp(-h^2 / 2) / (sqrt(2 pi) erf(slab_half / sqrt(2))) is as likely as
/// 1 / (2 slab_half). A plane's spread is 0.95, an even one 1.44 [noise].
constexpr double widest_spread = 1.185;

/// Points that one plane after the other is fitted to.
class PointsOfPlanes
{
public:
    /// \param chosen indices of points.
    PointsOfPlanes(const Points& points, const std::vector<int>& chosen);

    /// Least squares through what lies in the plane's slab; the normal keeps its side. \returns false if that does not
    /// span a plane.
    bool refit(NoisyPlane& plane, double noise) const;

    /// Points in the slab less twice those just beside it; 0 if they fill the slab evenly.
    double measure_support(const NoisyPlane& plane, double noise) const;

private:
    void sum(const NoisyPlane& plane, double noise, struct SlabSums* sums) const;

    int size_;   ///< Of the arrays, which are padded for whole vectors.
    Point base_; ///< Places are relative to it.
    std::vector<double> x_, y_, z_, is_point_;
};

/// Finds planes with bare ground between their points: those that hold many of the points around a seed while few lie
/// just above or below, grown as far as that lasts. \param points distinct, in spatial order. \param noise standard
/// deviation > 0. \returns the best supported first. The same for any number of threads.
std::vector<NoisyPlane> find_noisy_planes(const Points& points, double noise, int threads);

} // namespace recon
