#include <recon/noise/stray_samples.h>

#include <recon/noise/patch_fit.h>
#include <recon/parallel.h>
#include <recon/scramble.h>

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

namespace recon
{
namespace
{

constexpr std::size_t asked = 1'600;
constexpr int neighbours = 20, kept = 14;
constexpr int subsets = 60; // of six: with 3 of 20 off the surface a third of these are good ones, with 6 a thirteenth
/// Off the quadric [spacings]: less may be detail.
constexpr double least_off = 0.1;
/// The same by what the kept neighbours leave; neighbours that leave so many times as much are off it, too.
constexpr double least_ratio = 10, on_surface = 5;
/// So many of the nearest lie on it, and of these eight no two in turn leave a wider angle around the sample.
constexpr int nearest_on = 3, around = 8;
constexpr double widest_gap = 0.7 * EIGEN_PI;
/// What the least-squares quadric of all leaves there says that the sample is on the surface [spacings].
constexpr double surely_on = 0.02;

using Rows = Eigen::Matrix<double, neighbours, patch_coefficients>;
using Heights = Eigen::Matrix<double, neighbours, 1>;

/// Neighbours of a sample, nearest first, in their principal frame.
struct Surroundings
{
    Rows rows;
    Heights heights; ///< Along the normal [radii of the neighbourhood].
    PatchRow at_sample;
    double height = 0; ///< Of the sample.

    Heights residuals(const PatchRow& quadric) const { return (heights - rows * quadric).cwiseAbs(); }
    double offset(const PatchRow& quadric) const { return std::abs(height - at_sample.dot(quadric)); }
};

bool look_around(const Points& samples, const BlockSearch& search, const Point& sample, Surroundings& result)
{
    std::array<int, 1 + neighbours> near;
    std::array<double, 1 + neighbours> squared;
    if (search.nearest(sample, 1 + neighbours, near.data(), squared.data()) <= neighbours || !(squared.back() > 0))
        return false;
    Eigen::Matrix<double, 3, neighbours> offsets;
    for (int i = 0; i < neighbours; ++i)
        offsets.col(i) = (samples[std::size_t(near[std::size_t(i) + 1])] - sample) / std::sqrt(squared.back());
    const Vector middle = offsets.rowwise().mean();
    offsets.colwise() -= middle;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(offsets * offsets.transpose());
    const auto place = [&](const Vector& from) { return Vector(axes.eigenvectors().transpose() * from); };
    for (int i = 0; i < neighbours; ++i)
    {
        const Vector p = place(offsets.col(i));
        result.heights[i] = p[0];
        result.rows.row(i) = patch_row(p);
    }
    const Vector p = place(-middle);
    result.height = p[0];
    result.at_sample = patch_row(p);
    return true;
}

/// Of quadrics through six neighbours the one that the kept ones leave least of. \param seed of the choice.
PatchRow find_rough_quadric(const Surroundings& near, std::size_t seed)
{
    PatchRow best = PatchRow::Zero();
    double least = near.heights.cwiseAbs().maxCoeff();
    std::array<int, neighbours> order;
    std::iota(order.begin(), order.end(), 0);
    for (std::size_t subset = 0; subset < subsets; ++subset)
    {
        Eigen::Matrix<double, patch_coefficients, patch_coefficients> rows;
        PatchRow heights;
        for (int k = 0; k < patch_coefficients; ++k)
        {
            const double draw = scramble_to_unit((seed * subsets + subset) * patch_coefficients + std::size_t(k));
            std::swap(order[std::size_t(k)], order[std::size_t(k + int(draw * (neighbours - k)))]);
            rows.row(k) = near.rows.row(order[std::size_t(k)]);
            heights[k] = near.heights[order[std::size_t(k)]];
        }
        const PatchRow quadric = rows.partialPivLu().solve(heights);
        Heights left = near.residuals(quadric);
        std::nth_element(left.data(), left.data() + kept - 1, left.data() + neighbours);
        if (left[kept - 1] < least) // not of quadrics that are not finite
        {
            least = left[kept - 1];
            best = quadric;
        }
    }
    return best;
}

/// Least-squares quadric of the neighbours that a rough one leaves least of. \param left the root mean square of what
/// it leaves of these.
PatchRow fit_kept(const Surroundings& near, const PatchRow& rough, double& left)
{
    const Heights residuals = near.residuals(rough);
    std::array<int, neighbours> order;
    std::iota(order.begin(), order.end(), 0);
    std::nth_element(order.begin(), order.begin() + kept, order.end(),
                     [&](int a, int b) { return residuals[a] < residuals[b]; });
    Eigen::Matrix<double, kept, patch_coefficients> rows;
    Eigen::Matrix<double, kept, 1> heights;
    for (int i = 0; i < kept; ++i)
    {
        rows.row(i) = near.rows.row(order[std::size_t(i)]);
        heights[i] = near.heights[order[std::size_t(i)]];
    }
    const PatchRow quadric = rows.colPivHouseholderQr().solve(heights);
    left = std::sqrt((heights - rows * quadric).squaredNorm() / (kept - patch_coefficients));
    return quadric;
}

/// Whether the nearest neighbours lie on the quadric, and those that do around the sample.
bool is_surrounded(const Surroundings& near, const Heights& residuals, double on)
{
    std::vector<double> angles;
    for (int i = 0; i < around; ++i)
        if (residuals[i] < on)
            angles.push_back(std::atan2(near.rows(i, 2) - near.at_sample[2], near.rows(i, 1) - near.at_sample[1]));
        else if (i < nearest_on)
            return false;
    std::sort(angles.begin(), angles.end());
    double gap = angles.front() + 2 * EIGEN_PI - angles.back();
    for (std::size_t i = 1; i < angles.size(); ++i)
        gap = std::max(gap, angles[i] - angles[i - 1]);
    return gap < widest_gap;
}

bool is_stray(const Points& samples, const BlockSearch& search, std::size_t sample)
{
    Surroundings near;
    if (!look_around(samples, search, samples[sample], near))
        return false;
    const double spacing = std::sqrt(EIGEN_PI / neighbours);
    const PatchRow of_all = near.rows.colPivHouseholderQr().solve(near.heights);
    if (near.offset(of_all) < surely_on * spacing)
        return false;
    double left;
    PatchRow quadric = fit_kept(near, find_rough_quadric(near, sample), left);
    quadric = fit_kept(near, quadric, left);
    const double off = near.offset(quadric);
    return off > least_off * spacing && off > least_ratio * left &&
           is_surrounded(near, near.residuals(quadric), on_surface * left);
}

} // namespace

double measure_strays(const Points& samples, const BlockSearch& search, int threads)
{
    const std::size_t stride = std::max<std::size_t>(1, samples.size() / asked);
    const std::size_t count = (samples.size() + stride - 1) / stride;
    std::vector<char> strays(count);
    parallel_for(
        count, threads, {}, [&](std::size_t k) { strays[k] = is_stray(samples, search, k * stride); }, 8);
    return count > 0 ? double(std::count(strays.begin(), strays.end(), 1)) / double(count) : 0;
}

} // namespace recon
