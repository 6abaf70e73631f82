#include "normal_noise.h"

#include <recon/median.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <utility>

namespace recon::pn
{

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
    return median(std::move(errors)) / 1.1774; // the median length of two components
}

double contradiction_of_normals(const UsableSamples& usable)
{
    const OrientedSamples& samples = usable.samples;
    constexpr std::size_t enough = 5000;
    constexpr int near = 9, least = 3; // itself and 8 others
    constexpr double same_face = 0.7;  // cosine
    std::vector<double> contradictions;
    const std::size_t n = samples.points.size(), each = n / enough + 1;
    for (std::size_t i = 0; i < n; i += each)
    {
        double sum = 0;
        int count = 0;
        for (int m = 0; m < std::min(near, usable.nearest.count); ++m)
        {
            const auto j = std::size_t(usable.nearest.of(i)[m]);
            const Vector d = samples.points[j] - samples.points[i];
            const double length = d.norm();
            if (!(length > 0) || samples.normals[j].dot(samples.normals[i]) < same_face)
                continue;
            const double lean = (samples.normals[i] + samples.normals[j]).dot(d) / length;
            sum += lean * lean;
            ++count;
        }
        if (count >= least)
            contradictions.push_back(std::sqrt(sum / count));
    }
    return contradictions.empty() ? 0 : median(std::move(contradictions));
}

double slack_of_gradients(double normal_noise)
{
    constexpr double bends = 0.17, per_variance = 150; // [radians], [1 / radians^2]
    return per_variance * std::max(normal_noise * normal_noise - bends * bends, 0.0);
}

} // namespace recon::pn
