#pragma once

#include <recon/geometry.h>

#include "small_solve.h"

#include <array>
#include <vector>

namespace recon
{

/// Two vectors that complete the unit `normal` to a right-handed frame (t1 x t2 = normal): of unit length, or longer
/// and shorter by the same factor (stretched_frame.h), so that distances told in the frame are stretched.
struct TangentFrame
{
    explicit TangentFrame(const Vector& unit_normal);
    Vector normal, t1, t2;
};

/// Points with weights, and where needed directions, copied side by side for the vector units. Entries beyond the last
/// weigh nothing.
struct Gathered
{
    std::vector<float> x, y, z, weight;
    std::vector<float> nx, ny, nz; ///< Directions, only after gather_directions().
    int size = 0;

    void gather(const Points& points, const std::vector<double>& weights, const std::vector<int>& indices,
                const Point& origin);
    void gather_directions(const Vectors& directions, const std::vector<int>& indices);
    /// Those of `all` that weigh something, lie within `radius` of `origin`, by the lengths of `frame`, and whose
    /// direction has more than `least_cosine` with `normal`; without their directions.
    void gather_facing(const Gathered& all, const Point& origin, const TangentFrame& frame, double radius,
                       const Vector& normal, double least_cosine);

private:
    std::vector<int> chosen_;
};

/// Weighted mass, mean and smallest principal direction.
struct WeightedPlane
{
    double mass = 0;
    Point mean = Point::Zero();
    Vector normal = Vector::UnitZ();
    double spread = 0; ///< Variance along the middle principal direction [length^2].
};

/// Plane of the gathered points about `centre` with weights w exp(-d^2 / width^2), d <= cut width.
WeightedPlane fit_plane(const Gathered& points, const Point& centre, double width, double cut);

/// Height z = c . (1, u, v, u^2, uv, v^2) over a tangent frame, with u and v in units of the width; z in length.
struct QuadricFit
{
    std::array<double, 6> c{};
    double mass = 0;      ///< Sum of the weights.
    double effective = 0; ///< (sum w)^2 / sum w^2.
    bool valid = false;
};

/// Unit normal of the quadric over the frame's origin.
Vector normal_of(const QuadricFit& fit, const TangentFrame& frame, double width);

struct QuadricWeights
{
    double width;                             ///< h of exp(-d^2 / h^2) [length].
    double cut;                               ///< Points farther than this many widths do not count.
    double ridge_linear = 1e-4;               ///< Pull of the slopes to 0 [share of the mass].
    double ridge_quadratic = 2e-3;            ///< Pull of the curvatures to 0 [share of the mass].
    const QuadricFit* robust_about = nullptr; ///< Residuals from this fit lower the weights as (1 + (r/s)^2)^-2.
    double robust_scale = 1;                  ///< s [length].
};

/// Weighted quadric over the gathered points in the frame at `origin`.
QuadricFit fit_quadric(const Gathered& points, const Point& origin, const TangentFrame& frame,
                       const QuadricWeights& how);

} // namespace recon
