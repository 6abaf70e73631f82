#include "sample_surface.h"

#include "hermite_surface.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace recon::pn
{
namespace
{

constexpr double flat = 0.98;     ///< Of normals that agree so far a PN triangle is as good as anything.
constexpr int fitted = 10;        ///< Samples that the surface interpolates: 12 gain 1 % and cost a half more.
constexpr int around = 40;        ///< Among so many nearest,
constexpr double same_side = 0.3; ///< those whose normals agree so far with that of the triangle.
constexpr double least_move = 0.01, largest_move = 0.5; ///< Nothing is moved less or farther [spacings].

bool is_flat(const std::vector<WorkPoint>& level, const std::array<int, 3>& corners)
{
    const auto normal = [&](std::size_t m) -> const Vector& { return level[std::size_t(corners[m])].normal; };
    return normal(0).dot(normal(1)) >= flat && normal(1).dot(normal(2)) >= flat && normal(2).dot(normal(0)) >= flat;
}

/// Of the gradients at the samples. Sparse samples of a bent surface look a little as if their normals were noisy.
double slack_of(double normal_noise)
{
    constexpr double bends = 0.17, per_variance = 150; // [radians], [1 / radians^2]
    return per_variance * std::max(normal_noise * normal_noise - bends * bends, 0.0);
}

} // namespace

double estimate_normal_noise(const UsableSamples& usable)
{
    const OrientedSamples& samples = usable.samples;
    constexpr std::size_t enough = 5000;
    constexpr int near = 13, least = 7; // itself and 12 others
    std::vector<double> errors;
    const std::size_t n = samples.points.size(), each = n / enough + 1;
    for (std::size_t i = 0; i < n; i += each)
    {
        const Vector& normal = samples.normals[i];
        const Vector e1 = normal.unitOrthogonal(), e2 = normal.cross(e1);
        Eigen::Matrix3d squares = Eigen::Matrix3d::Zero(), products = Eigen::Matrix3d::Zero();
        const int found = std::min(near, usable.nearest.count);
        const double reach = (samples.points[std::size_t(usable.nearest.of(i)[found - 1])] - samples.points[i]).norm();
        int count = 0;
        for (int m = 0; m < found; ++m)
        {
            const auto j = std::size_t(usable.nearest.of(i)[m]);
            if (j == i || usable.is_crease[j] || samples.normals[j].dot(normal) < 0)
                continue;
            const Vector d = (samples.points[j] - samples.points[i]) / reach;
            const Vector row(1, d.dot(e1), d.dot(e2));
            squares += row * row.transpose();
            products += row * samples.normals[j].transpose();
            ++count;
        }
        if (count < least)
            continue;
        const Eigen::FullPivLU<Eigen::Matrix3d> solver(squares);
        if (!(solver.rcond() > 1e-6))
            continue;
        const Eigen::Matrix3d inverse = solver.inverse();
        const Vector expected = (inverse * products).row(0);
        const Vector off = normal - expected;
        // The prediction errs as well.
        errors.push_back((off - off.dot(normal) * normal).norm() / std::sqrt(1 + inverse(0, 0)));
    }
    if (errors.empty())
        return 0;
    const auto middle = errors.begin() + std::ptrdiff_t(errors.size() / 2);
    std::nth_element(errors.begin(), middle, errors.end());
    return *middle / 1.1774; // the median length of two components
}

void move_onto_sample_surface(const UsableSamples& usable, double normal_noise, const std::vector<WorkPoint>& level,
                              const std::array<int, 3>& corners, WorkPoint& made)
{
    if (is_flat(level, corners))
        return;
    int nearest[around], chosen[fitted], count = 0;
    double squared[around];
    const int found = usable.search->nearest(made.position, around, nearest, squared);
    for (int m = 0; m < found && count < fitted; ++m)
    {
        const auto j = std::size_t(nearest[m]);
        if (usable.is_crease[j])
            return;
        if (usable.samples.normals[j].dot(made.normal) > same_side)
            chosen[count++] = nearest[m];
    }
    if (count < fitted)
        return;
    const HermiteSurface surface(usable.samples, chosen, count, made.position, double(made.spacing),
                                 slack_of(normal_noise));
    Point p = made.position;
    const Vector gradient = surface.project(p);
    const double slope = gradient.norm(); // 1 at the samples
    // Where the two agree the triangle is kept: it is exact on spheres, the surface is not.
    const double move = (p - made.position).norm() / double(made.spacing);
    if (slope > 0.2 && slope < 5 && move > least_move && move < largest_move)
    {
        made.position = p;
        made.normal = gradient / slope;
    }
}

} // namespace recon::pn
