#include "stretched_frame.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

constexpr double half_exponent = 0.75;   // of s
constexpr double points_per_stretch = 8; // effective points for each s^2: fewer do not hold a quadric across the bend

} // namespace

TangentFrame stretch_along_bend(const QuadricFit& fit, const TangentFrame& frame, const Vector& normal, double width,
                                double sigma)
{
    TangentFrame result(normal);
    const Eigen::Matrix3d q = bending_of(fit, frame, width);
    // Q on the tangent plane: [[mean + twist[0], twist[1]], [twist[1], mean - twist[0]]].
    const double first = result.t1.dot(q * result.t1), second = result.t2.dot(q * result.t2);
    const double mean = 0.5 * (first + second);
    const Eigen::Vector2d twist(0.5 * (first - second), result.t1.dot(q * result.t2));
    const double hidden = sigma / (width * width);
    const double ratio = (std::abs(mean + twist.norm()) + hidden) / (std::abs(mean - twist.norm()) + hidden);
    if (!(ratio > 0) || !std::isfinite(ratio))
        return result;
    const double angle = 0.5 * std::atan2(twist[1], twist[0]);
    const double most = std::clamp(std::sqrt(fit.effective / points_per_stretch), 1.0, most_stretch);
    const double s = std::clamp(std::pow(ratio, half_exponent), 1 / most, most);
    const Vector along = std::cos(angle) * result.t1 + std::sin(angle) * result.t2;
    result.t1 = s * along;
    result.t2 = normal.cross(along) / s;
    return result;
}

double stretch_of(const TangentFrame& frame)
{
    const double s = frame.t1.norm();
    return std::max(s, 1 / s);
}

Eigen::Matrix3d bending_of(const QuadricFit& fit, const TangentFrame& frame, double width)
{
    const double scale = 1 / (width * width);
    const Eigen::Matrix3d mixed = frame.t1 * frame.t2.transpose();
    return scale * (fit.c[3] * frame.t1 * frame.t1.transpose() + fit.c[5] * frame.t2 * frame.t2.transpose() +
                    0.5 * fit.c[4] * (mixed + mixed.transpose()));
}

QuadricFit with_bending_in(const TangentFrame& other, const QuadricFit& fit, const TangentFrame& frame)
{
    const Eigen::Matrix3d q = bending_of(fit, frame, 1);
    // A point with the coordinates u, v lies at u a + v b.
    const Vector a = other.t1 / other.t1.squaredNorm(), b = other.t2 / other.t2.squaredNorm();
    QuadricFit result = fit;
    result.c = {0, 0, 0, a.dot(q * a), 2 * a.dot(q * b), b.dot(q * b)};
    return result;
}

} // namespace recon
