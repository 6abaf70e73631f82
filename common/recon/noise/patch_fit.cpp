#include <recon/noise/patch_fit.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recon
{
namespace
{

constexpr double pi = 3.14159265358979323846;
constexpr int coefficients = patch_coefficients;
using Row = PatchRow;

/// Gradient of the quadric with coefficients `c`.
Eigen::Vector2d slope_at(const Vector& u, const Row& c)
{
    return {c[1] + 2 * c[3] * u[1] + c[4] * u[2], c[2] + c[4] * u[1] + 2 * c[5] * u[2]};
}

/// Least squares of the heights by the rows of length `size`, row_of(residual).
template <int size, class RowOf>
Eigen::Matrix<double, size, 1> solve_for_heights(const std::vector<PatchResidual>& residuals, RowOf&& row_of)
{
    Eigen::Matrix<double, size, size> normal_matrix;
    normal_matrix.setZero();
    Eigen::Matrix<double, size, 1> right = Eigen::Matrix<double, size, 1>::Zero();
    for (std::size_t i = 0; i < residuals.size(); ++i)
    {
        const Eigen::Matrix<double, size, 1> row = row_of(i);
        normal_matrix += row * row.transpose();
        right += row * residuals[i].place[0];
    }
    // Keeps collinear neighbours (scan lines) solvable; far below any noise.
    normal_matrix.diagonal().array() += 1e-12 * double(residuals.size());
    return normal_matrix.ldlt().solve(right);
}

} // namespace

PatchFit fit_patch(const Points& points, const Point& seed, const int* neighbours, int count, double radius,
                   std::vector<PatchResidual>& residuals)
{
    residuals.clear();
    if (count <= coefficients || !(radius > 0))
        return {0, 0, 3, Vector::UnitZ(), seed};
    Vector mean = Vector::Zero();
    for (int i = 0; i < count; ++i)
        mean += points[neighbours[i]] - seed;
    mean /= count;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (int i = 0; i < count; ++i)
    {
        const Vector d = (points[neighbours[i]] - seed - mean) / radius;
        covariance += d * d.transpose();
    }
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(covariance);
    const Eigen::Matrix3d frame = solver.eigenvectors();
    for (int i = 0; i < count; ++i)
        residuals.push_back({frame.transpose() * ((points[neighbours[i]] - seed - mean) / radius), 0});
    const Row solution =
        solve_for_heights<coefficients>(residuals, [&](std::size_t i) { return patch_row(residuals[i].place); });
    double heights = 0, distances = 0, fourth = 0;
    for (PatchResidual& r : residuals)
    {
        r.height = r.place[0] - patch_row(r.place).dot(solution);
        const double square = r.height * r.height;
        heights += square;
        fourth += square * square;
        // Where the quadric is steep the same noise is taller.
        distances += square / (1 + slope_at(r.place, solution).squaredNorm());
    }
    const Vector at_seed = frame.transpose() * (-mean / radius);
    const double height = std::clamp(patch_row(at_seed).dot(solution) - at_seed[0], -1.0, 1.0);
    const auto deviation = [&](double squares) { return radius * std::sqrt(squares / (count - coefficients)); };
    return {deviation(heights), deviation(distances), heights > 0 ? count * fourth / (heights * heights) : 3,
            frame.col(0), seed + radius * height * frame.col(0)};
}

std::optional<TwoSheets> fit_two_sheets(const std::vector<PatchResidual>& residuals, double radius)
{
    constexpr int fewest = 3 * coefficients, rounds = 3;
    constexpr double left_by_sheets = 0.5, largest_agreement = 0.65;
    constexpr double middle = 0.1;        // of the step, to either side
    constexpr double smallest_step = 1.3; // spacings of both together; scans out of register are nearer
    const int n = int(residuals.size());
    if (n < fewest)
        return {};
    double before = 0;
    std::vector<char> is_above;
    for (const PatchResidual& r : residuals)
    {
        before += r.height * r.height;
        is_above.push_back(r.height > 0);
    }
    using LongRow = Eigen::Matrix<double, coefficients + 1, 1>;
    double after = 0, fourth = 0, step = 0;
    int between = 0;
    for (int round = 0; round < rounds; ++round)
    {
        const auto long_row = [&](std::size_t i)
        {
            LongRow row;
            row << patch_row(residuals[i].place), is_above[i] ? 1.0 : -1.0;
            return row;
        };
        const LongRow solution = solve_for_heights<coefficients + 1>(residuals, long_row);
        step = 2 * solution[coefficients];
        after = fourth = 0;
        between = 0;
        for (std::size_t i = 0; i < residuals.size(); ++i)
        {
            const double rest = residuals[i].place[0] - long_row(i).dot(solution);
            after += rest * rest;
            fourth += rest * rest * rest * rest;
            const double height =
                residuals[i].place[0] - patch_row(residuals[i].place).dot(solution.head<coefficients>());
            between += std::abs(height) < middle * step;
            is_above[i] = height > 0;
        }
    }
    if (after / (n - coefficients - 1) > left_by_sheets * left_by_sheets * before / (n - coefficients))
        return {};
    const double spacing = std::sqrt(pi / n);
    if (step < smallest_step * spacing)
        return {};
    // Of the fewer ones: a ball around one sheet cuts a smaller disc out of the other.
    const char fewer = 2 * std::count(is_above.begin(), is_above.end(), 1) <= n;
    int agreeing = 0, asked = 0;
    for (int i = 0; i < n; ++i)
    {
        if (is_above[i] != fewer)
            continue;
        int nearest = i;
        double least = std::numeric_limits<double>::infinity();
        for (int j = 0; j < n; ++j)
        {
            const double squared = (residuals[j].place - residuals[i].place).tail<2>().squaredNorm();
            if (j != i && squared < least)
            {
                least = squared;
                nearest = j;
            }
        }
        agreeing += is_above[i] == is_above[nearest];
        ++asked;
    }
    if (asked == 0 || agreeing > largest_agreement * asked)
        return {};
    return TwoSheets{radius * std::sqrt(after / (n - coefficients - 1)), after > 0 ? n * fourth / (after * after) : 3,
                     between / double(n)};
}

} // namespace recon
