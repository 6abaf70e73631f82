#include "anchor_sums.h"

#include "surface_data.h"

#include <recon/simd.h>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

using Lanes = simd::FloatLanes;

constexpr double slack = 0.35;  // widths: how far a point may move before its anchors are gathered again
constexpr double uneven = 1.25; // root of the ratio of neighbouring widths

} // namespace

void GatheredAnchors::gather(const AmlsSurface::Data& data, const Point& centre, double radius, double width,
                             double cut_off)
{
    centre_ = centre;
    width_ = width * (1 + 1e-12);
    radius_ = radius + slack * width;
    const double reach = narrowing * cut_off;
    data.anchor_search.within(centre, radius_ + reach * uneven * width, found_);
    const auto is_beyond = [&](int i)
    {
        const Anchor& a = data.anchors[i];
        const double farthest = radius_ + reach * std::sqrt(width_ * a.width);
        return (a.position - centre).squaredNorm() > farthest * farthest;
    };
    found_.erase(std::remove_if(found_.begin(), found_.end(), is_beyond), found_.end());
    stride_ = std::size_t(simd::padded(int(found_.size())));
    values_.assign(stride_ * field_count, 0);
    for (std::size_t i = 0; i < found_.size(); ++i)
    {
        const Anchor& a = data.anchors[found_[i]];
        float* value = &values_[i];
        for (int k = 0; k < 3; ++k)
        {
            value[(x + k) * stride_] = float(a.position[k] - centre[k]);
            value[(nx + k) * stride_] = float(a.normal[k]);
        }
        for (int k = 0; k < 6; ++k)
            value[(qxx + k) * stride_] = float(a.bending[k]);
        value[confidence * stride_] = float(a.confidence);
        value[inverse_width * stride_] = float(1 / (narrowing * narrowing * a.width));
    }
}

RECON_VECTOR_CLONES
void sum_anchors(const float* values, std::size_t stride, const float* p, const float* side, float inverse_width,
                 float cut, const Agreement& agreement, AnchorSums* sums)
{
    using G = GatheredAnchors;
    Lanes weight = {}, distance = {}, gx = {}, gy = {}, gz = {}, sx = {}, sy = {}, sz = {}, count = {};
    const float* face = agreement.normal;
    const float limit = cut * cut;
    const Lanes zero = {}, one = zero + 1.0f, most = zero + 8.0f;
    for (std::size_t i = 0; i < stride; i += simd::lane_count)
    {
        const float* v = values + i;
        const Lanes ux = p[0] - simd::load(v + G::x * stride), uy = p[1] - simd::load(v + G::y * stride),
                    uz = p[2] - simd::load(v + G::z * stride);
        const Lanes nx = simd::load(v + G::nx * stride), ny = simd::load(v + G::ny * stride),
                    nz = simd::load(v + G::nz * stride);
        const Lanes e = (ux * ux + uy * uy + uz * uz) * (simd::load(v + G::inverse_width * stride) * inverse_width);
        const Lanes facing = nx * side[0] + ny * side[1] + nz * side[2];
        Lanes w = simd::load(v + G::confidence * stride) * simd::exp_negative(e < most ? e : most);
        w = e <= limit ? w : zero;
        w = facing > zero ? w : zero;
        const Lanes qxy = simd::load(v + G::qxy * stride), qxz = simd::load(v + G::qxz * stride),
                    qyz = simd::load(v + G::qyz * stride);
        const Lanes qx = simd::load(v + G::qxx * stride) * ux + qxy * uy + qxz * uz,
                    qy = qxy * ux + simd::load(v + G::qyy * stride) * uy + qyz * uz,
                    qz = qxz * ux + qyz * uy + simd::load(v + G::qzz * stride) * uz;
        const Lanes d = ux * (nx - qx) + uy * (ny - qy) + uz * (nz - qz);
        const Lanes off = d * agreement.inverse_distance;
        const Lanes turn = (one - (nx * face[0] + ny * face[1] + nz * face[2])) * agreement.turning;
        const Lanes depths = d * (ux * face[0] + uy * face[1] + uz * face[2]) * -agreement.crease;
        const Lanes beyond = depths > zero ? depths : zero;
        const Lanes near = 1.0f / (1.0f + off * off), alike = 1.0f / (1.0f + off * off * (one + turn) + beyond);
        const Lanes smooth = w * near * near;
        w *= alike * alike;
        const Lanes dx = nx - 2.0f * qx, dy = ny - 2.0f * qy, dz = nz - 2.0f * qz;
        weight += w;
        distance += w * d;
        gx += w * dx;
        gy += w * dy;
        gz += w * dz;
        sx += smooth * dx;
        sy += smooth * dy;
        sz += smooth * dz;
        count += w > zero ? one : zero;
    }
    sums->weight = simd::sum(weight);
    sums->distance = simd::sum(distance);
    sums->gradient[0] = simd::sum(gx);
    sums->gradient[1] = simd::sum(gy);
    sums->gradient[2] = simd::sum(gz);
    sums->smooth_gradient[0] = simd::sum(sx);
    sums->smooth_gradient[1] = simd::sum(sy);
    sums->smooth_gradient[2] = simd::sum(sz);
    sums->count = simd::sum(count);
}

} // namespace recon
