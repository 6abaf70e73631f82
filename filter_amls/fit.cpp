#include "fit.h"

#include "runs.h"
#include "weighted_sums.h"

#include <recon/block_search.h>
#include <recon/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recon
{
namespace
{

constexpr double fit_cut = 2.4; // widths
/// Residuals beyond it lose weight in the second fit [sigma]: the candidates.
constexpr std::array<double, 8> robust_scales = {0.5, 0.7, 1, 1.4, 2, 2.8, 4, 6};
/// Residuals of a fit are more alike than the noise itself, so of nearly equal candidates the narrowest is best.
constexpr double nearly_least = 1.1;
constexpr std::size_t asked_fits = 300;
constexpr double least_points = 12;     // effective points of a fit whose residuals tell something
constexpr double farthest_residual = 6; // sigmas; beyond it is no noise
constexpr double largest_turn = 0.5;    // cosine
constexpr double largest_move = 0.4;    // widths
constexpr double largest_move_sigmas = 2.5;
constexpr double enough_points = 60;  // more effective points do not raise the confidence
constexpr double doubtful_move = 0.5; // widths
constexpr double run_radius = 0.9;    // widths
constexpr int longest_run = 32;

std::array<double, 6> bending_of(const QuadricFit& fit, double width, const TangentFrame& frame)
{
    const double uu = fit.c[3] / (width * width), uv = fit.c[4] / (width * width), vv = fit.c[5] / (width * width);
    const Eigen::Matrix3d q = uu * frame.t1 * frame.t1.transpose() + vv * frame.t2 * frame.t2.transpose() +
                              0.5 * uv * (frame.t1 * frame.t2.transpose() + frame.t2 * frame.t1.transpose());
    return {q(0, 0), q(1, 1), q(2, 2), q(0, 1), q(0, 2), q(1, 2)};
}

/// `gathered` holds the samples around, relative to `origin`.
Anchor fit_anchor(const Gathered& gathered, const Point& origin, const FitStart& start, double robustness)
{
    const double width = start.width;
    const Vector& normal = start.normal;
    Anchor anchor{start.foot, normal, {}, 0, width};
    QuadricWeights how{width, fit_cut};
    how.same_side_only = true;
    how.robust_scale = robustness * start.sigma;

    Point position = start.foot - origin;
    Vector direction = normal;
    QuadricFit fit;
    std::array<double, 6> bending{};
    double plane_confidence = 0;
    for (int round = 0; round < 2; ++round)
    {
        const TangentFrame frame(direction);
        QuadricFit moved = fit;
        if (round > 0)
        {
            // The first surface seen from the frame moved and turned to it: neither offset nor slope are left.
            moved.c[0] = moved.c[1] = moved.c[2] = 0;
            how.robust_about = &moved;
        }
        const QuadricFit next = fit_quadric(gathered, position, frame, how);
        if (round == 0)
            plane_confidence = std::min(next.effective, enough_points);
        if (!next.valid)
        {
            if (round > 0)
                break;
            anchor.confidence = std::min(next.effective, 1.0);
            return anchor;
        }
        fit = next;
        bending = bending_of(fit, width, frame);
        position += fit.c[0] * direction;
        direction = (direction - fit.c[1] / width * frame.t1 - fit.c[2] / width * frame.t2).normalized();
    }
    const double moved = (position + origin - start.foot).norm();
    if (!position.allFinite() || !direction.allFinite() || direction.dot(normal) < largest_turn ||
        moved > std::max(largest_move * width, largest_move_sigmas * start.sigma))
    {
        anchor.confidence = plane_confidence;
        return anchor;
    }
    const double doubt = moved / (doubtful_move * width);
    anchor.position = position + origin;
    anchor.normal = direction;
    anchor.bending = bending;
    anchor.confidence = std::min(fit.effective, enough_points) * std::exp(-doubt * doubt);
    return anchor;
}

/// Collects for each of `robust_scales` the sums of psi^2, psi' and the count over the residuals of one fit by least
/// squares, in units of sigma; psi(r) = r (1 + (r/s)^2)^-2.
void add_residuals(const Gathered& gathered, const Point& origin, const FitStart& start, double* sums)
{
    QuadricWeights how{start.width, fit_cut};
    how.same_side_only = true;
    const TangentFrame frame(start.normal);
    const Point position = start.foot - origin;
    const QuadricFit fit = fit_quadric(gathered, position, frame, how);
    if (!fit.valid || fit.effective < least_points)
        return;
    for (int i = 0; i < gathered.size; ++i)
    {
        const Vector d = Point(gathered.x[i], gathered.y[i], gathered.z[i]) - position;
        const double u = d.dot(frame.t1) / start.width, v = d.dot(frame.t2) / start.width;
        const double facing =
            gathered.nx[i] * start.normal.x() + gathered.ny[i] * start.normal.y() + gathered.nz[i] * start.normal.z();
        if (u * u + v * v > 1 || !(facing > 0) || !(gathered.weight[i] > 0))
            continue;
        const double height =
            fit.c[0] + fit.c[1] * u + fit.c[2] * v + fit.c[3] * u * u + fit.c[4] * u * v + fit.c[5] * v * v;
        const double r = (d.dot(start.normal) - height) / start.sigma;
        if (std::abs(r) > farthest_residual)
            continue;
        for (std::size_t k = 0; k < robust_scales.size(); ++k)
        {
            const double q = r * r / (robust_scales[k] * robust_scales[k]), w = 1 / ((1 + q) * (1 + q));
            sums[3 * k] += r * r * w * w;
            sums[3 * k + 1] += w * (1 - 3 * q) / (1 + q);
            sums[3 * k + 2] += 1;
        }
    }
}

/// How far residuals may be off before they lose weight [sigma]: about that with the least asymptotic variance of the
/// estimate, E psi^2 / (E psi')^2. Gaussian noise wants least squares; where some points are much better than others,
/// those should decide.
double choose_robustness(const FitSamples& samples, const std::vector<FitStart>& starts, int threads)
{
    constexpr std::size_t width = 3 * robust_scales.size();
    const std::size_t stride = std::max<std::size_t>(1, starts.size() / asked_fits), n = starts.size() / stride;
    std::vector<std::array<double, width>> parts(n, std::array<double, width>{});
    parallel_chunks(n, threads, 16, {},
                    [&](std::size_t begin, std::size_t end)
                    {
                        std::vector<int> found;
                        Gathered gathered;
                        for (std::size_t i = begin; i < end; ++i)
                        {
                            const FitStart& start = starts[i * stride];
                            samples.search.within(start.foot, fit_cut * start.width, found);
                            gathered.gather(samples.points, samples.weights, found, start.foot);
                            gathered.gather_directions(samples.normals, found);
                            add_residuals(gathered, start.foot, start, parts[i].data());
                        }
                    });
    std::array<double, width> total{};
    for (const auto& part : parts)
        for (std::size_t k = 0; k < width; ++k)
            total[k] += part[k];
    std::array<double, robust_scales.size()> variance;
    for (std::size_t k = 0; k < robust_scales.size(); ++k)
    {
        const double slope = total[3 * k + 1];
        variance[k] =
            slope > 0 ? total[3 * k] * total[3 * k + 2] / (slope * slope) : std::numeric_limits<double>::infinity();
    }
    const double enough = nearly_least * *std::min_element(variance.begin(), variance.end());
    std::size_t k = 0;
    while (k + 1 < robust_scales.size() && !(variance[k] <= enough))
        ++k;
    return robust_scales[k];
}

} // namespace

std::vector<Anchor> fit_anchors(const FitSamples& samples, const std::vector<FitStart>& starts, int threads,
                                const Progress& progress)
{
    const double robustness = choose_robustness(samples, starts, threads);
    std::vector<Anchor> result(starts.size());
    Points feet;
    for (const FitStart& start : starts)
        feet.push_back(start.foot);
    const std::vector<Run> runs =
        split_into_runs(feet, longest_run, [&](int i) { return run_radius * starts[i].width; });
    parallel_chunks(runs.size(), threads, 64, progress,
                    [&](std::size_t begin, std::size_t end)
                    {
                        std::vector<int> found;
                        Gathered gathered;
                        for (std::size_t r = begin; r < end; ++r)
                        {
                            const Run& run = runs[r];
                            double reach = 0;
                            for (int a = run.begin; a < run.end; ++a)
                                reach = std::max(reach, (fit_cut + 0.2) * starts[a].width);
                            samples.search.within(run.centre, run.radius + reach, found);
                            gathered.gather(samples.points, samples.weights, found, run.centre);
                            gathered.gather_directions(samples.normals, found);
                            for (int a = run.begin; a < run.end; ++a)
                                result[a] = fit_anchor(gathered, run.centre, starts[a], robustness);
                        }
                    });
    return result;
}

} // namespace recon
