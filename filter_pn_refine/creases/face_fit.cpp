#include "face_fit.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace recon::pn
{

namespace
{

constexpr int wanted = 6;              ///< Samples of a face.
constexpr double same_face = 0.7;      ///< Normals that agree more,
constexpr double steepest = 0.7;       ///< places under a smaller sine.
constexpr double largest_error = 0.07; ///< [radians] Smooth shapes that are sampled sparsely have more.

/// Calls use(normal, d, lean) for the nearest samples on the face of sample i, d away: those whose normals
/// agree with its own, and more than with `across`. On a circle through both the two normals lean against the chord
/// alike, whatever its radius: `lean` [sine] is by how much they do not. \returns how many.
template <class Use>
int for_each_on_face(const UsableSamples& usable, std::size_t i, const Vector* across, const Use& use)
{
    const Vector& own = usable.samples.normals[i];
    int count = 0;
    for (int m = 0; m < usable.nearest.count && count < wanted; ++m)
    {
        const auto j = std::size_t(usable.nearest.of(i)[m]);
        const Vector& n = usable.samples.normals[j];
        const Vector d = usable.samples.points[j] - usable.samples.points[i];
        const double length = d.norm(), agreement = n.dot(own);
        if (!(length > 0) || agreement < same_face || (across && agreement <= n.dot(*across)) ||
            std::abs(d.dot(own)) > steepest * length)
            continue;
        use(n, d, (n + own).dot(d) / length);
        ++count;
    }
    return count;
}

} // namespace

FaceFit::FaceFit(const UsableSamples& usable, std::size_t i, const Vector& across)
    : centre_(usable.samples.points[i]), normal_(usable.samples.normals[i]), e1_(normal_.unitOrthogonal()),
      e2_(normal_.cross(e1_))
{
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    double sum = 0;
    const auto add = [&](double x, double y, double z, double value)
    {
        const Eigen::Vector3d row(x, y, z);
        squares += row * row.transpose();
        right += value * row;
        sum += value * value;
    };
    count_ = for_each_on_face(usable, i, &across,
                              [&](const Vector& n, const Vector& d, double lean)
                              {
                                  const double u = d.dot(e1_), v = d.dot(e2_);
                                  add(u, v, 0, -n.dot(e1_));
                                  add(0, u, v, -n.dot(e2_));
                                  sum += lean * lean;
                              });
    if (!is_known())
        return;
    turns_ = squares.fullPivLu().solve(right);
    error_ = std::sqrt(std::max(sum - turns_.dot(right), 0.0) / (3 * count_ - 3));
}

Vector FaceFit::normal_at(const Point& x) const
{
    const Vector d = x - centre_;
    const double u = d.dot(e1_), v = d.dot(e2_);
    const double a = turns_[0] * u + turns_[1] * v, b = turns_[1] * u + turns_[2] * v;
    return (std::sqrt(std::max(1 - a * a - b * b, 0.0)) * normal_ - a * e1_ - b * e2_).normalized();
}

bool may_end_sharply(const UsableSamples& usable, std::size_t i)
{
    double sum = 0; // what leans alone add to the error of a FaceFit
    const int count =
        for_each_on_face(usable, i, nullptr, [&](const Vector&, const Vector&, double lean) { sum += lean * lean; });
    return count > 0 && sum <= largest_error * largest_error * 3 * count;
}

bool ends_sharply(const UsableSamples& usable, std::size_t i, std::size_t j, const Point& x, double least_agreement)
{
    const FaceFit a(usable, i, usable.samples.normals[j]), b(usable, j, usable.samples.normals[i]);
    return a.is_known() && b.is_known() && std::max(a.error(), b.error()) < largest_error &&
           a.normal_at(x).dot(b.normal_at(x)) < least_agreement;
}

} // namespace recon::pn
