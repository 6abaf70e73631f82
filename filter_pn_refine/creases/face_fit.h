#pragma once

#include "filter_pn_refine/samples/usable_samples.h"

#include <cstddef>

namespace recon::pn
{

/// How the face on which a sample lies goes on: how its normal turns along the tangent plane (the shape operator),
/// fitted to the nearest samples of the face. Exact for planes, spheres and cylinders.
class FaceFit
{
public:
    /// The face of sample i, which ends at an edge with a face of normal `across`.
    FaceFit(const UsableSamples& usable, std::size_t i, const Vector& across);

    /// Whether there were enough samples.
    bool is_known() const { return count_ >= least; }
    /// By how much places and normals of these samples differ from the fit [radians, root mean square].
    double error() const { return error_; }
    /// Normal of the face at a point near the sample.
    Vector normal_at(const Point& x) const;

private:
    static constexpr int least = 3;
    Point centre_;
    Vector normal_, e1_, e2_;
    Eigen::Vector3d turns_ = Eigen::Vector3d::Zero(); ///< Of the symmetric operator: (e1, e1), (e1, e2), (e2, e2).
    int count_ = 0;
    double error_ = 0;
};

/// Whether a sample may lie on a face that ends_sharply() somewhere: a cheap test that few noisy ones pass.
bool may_end_sharply(const UsableSamples& usable, std::size_t i);

/// Whether two samples lie on faces that end sharply at x: both faces are as smooth as their samples say, and where
/// they go on to x their normals still differ by more than the angle of this cosine. Where a surface only bends within
/// a spacing, or where normals or places are noisy, this is not so.
bool ends_sharply(const UsableSamples& usable, std::size_t i, std::size_t j, const Point& x, double least_agreement);

} // namespace recon::pn
