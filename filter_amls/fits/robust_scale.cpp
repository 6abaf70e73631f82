#include "robust_scale.h"

#include "weighted_sums.h"

#include <recon/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace recon
{
namespace
{

/// Residuals beyond it lose weight [sigma]: the candidates.
constexpr std::array<double, 8> robust_scales = {0.5, 0.7, 1, 1.4, 2, 2.8, 4, 6};
/// Residuals of a fit are more alike than the noise itself, so of nearly equal candidates the narrowest is best.
constexpr double nearly_least = 1.1;
constexpr std::size_t asked_fits = 300;
constexpr double least_points = 12;     // effective points of a fit whose residuals tell something
constexpr double farthest_residual = 6; // sigmas; beyond it is no noise

/// Collects for each of `robust_scales` the sums of psi^2, psi' and the count over the residuals of one fit by least
/// squares, in units of sigma; psi(r) = r (1 + (r/s)^2)^-2. \param gathered with the foot of `start` as origin.
void add_residuals(const Gathered& gathered, const FitStart& start, double* sums)
{
    const QuadricWeights how{start.width, fit_cut};
    const TangentFrame frame(start.normal);
    const QuadricFit fit = fit_quadric(gathered, Point::Zero(), frame, how);
    if (!fit.valid || fit.effective < least_points)
        return;
    for (int i = 0; i < gathered.size; ++i)
    {
        const Vector d(gathered.x[i], gathered.y[i], gathered.z[i]);
        const double u = d.dot(frame.t1) / start.width, v = d.dot(frame.t2) / start.width;
        if (u * u + v * v > 1)
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

} // namespace

double choose_robust_scale(const FitSamples& samples, const std::vector<FitStart>& starts, int threads)
{
    constexpr std::size_t width = 3 * robust_scales.size();
    const std::size_t stride = std::max<std::size_t>(1, starts.size() / asked_fits), n = starts.size() / stride;
    std::vector<std::array<double, width>> parts(n, std::array<double, width>{});
    parallel_chunks(n, threads, 16, {},
                    [&](std::size_t begin, std::size_t end)
                    {
                        std::vector<int> found;
                        Gathered around, facing;
                        for (std::size_t i = begin; i < end; ++i)
                        {
                            const FitStart& start = starts[i * stride];
                            samples.search.within(start.foot, fit_cut * start.width, found);
                            around.gather(samples.points, samples.weights, found, start.foot);
                            around.gather_directions(samples.normals, found);
                            facing.gather_facing(around, Point::Zero(), TangentFrame(start.normal),
                                                 fit_cut * start.width, start.normal, 0);
                            add_residuals(facing, start, parts[i].data());
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

} // namespace recon
