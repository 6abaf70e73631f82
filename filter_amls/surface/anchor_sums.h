#pragma once

#include "surface.h"

#include <cstddef>
#include <vector>

namespace recon
{

/// Anchors near a ball of points, side by side for the vector units.
class GatheredAnchors
{
public:
    static constexpr double narrowing = 0.85; ///< Of the widths: quadrics need less averaging than planes.

    enum Field
    {
        x,
        y,
        z,
        nx,
        ny,
        nz,
        qxx,
        qyy,
        qzz,
        qxy,
        qxz,
        qyz,
        confidence,
        inverse_width,
        field_count
    };

    /// Those that count at points of up to `width` within `radius` of `centre`, and somewhat farther.
    void gather(const AmlsSurface::Data& data, const Point& centre, double radius, double width, double cut_off);

    /// Whether they suffice for a point.
    bool suffice(const Point& p, double width) const { return width <= width_ && (p - centre_).norm() <= radius_; }

    const float* values() const { return values_.data(); }
    std::size_t stride() const { return stride_; }
    const Point& centre() const { return centre_; } ///< Origin of their positions.

private:
    std::vector<int> found_;
    std::vector<float> values_;
    std::size_t stride_ = 0;
    Point centre_ = Point::Zero();
    double radius_ = 0, width_ = 0;
};

/// Which anchors agree with a point: those that pass it nearby, the nearer the less they face as the surface does
/// there. Those beyond a crease do not: they lie below the plane at the point, and it below them, or both above.
struct Agreement
{
    float inverse_distance = 0;  ///< 0: all that pass it do.
    float normal[3] = {0, 0, 0}; ///< Of the surface at the point.
    float turning = 0;
    float crease = 0; ///< Times the product of both depths: how much less those beyond a crease agree; 0: they do.
};

/// W, sum theta d, sum theta grad d, and the number of anchors that count; smooth_gradient: wherever they face.
struct AnchorSums
{
    double weight, distance, gradient[3], smooth_gradient[3], count;
};

/// Over the gathered anchors of which `side` is in the half space, at `p` from their centre. \param inverse_width of
/// the point. \param cut beyond it they do not count [widths].
void sum_anchors(const float* values, std::size_t stride, const float* p, const float* side, float inverse_width,
                 float cut, const Agreement& agreement, AnchorSums* sums);

} // namespace recon
