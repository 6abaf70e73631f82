#include "bend_correction.h"

#include <recon/block_search.h>
#include <recon/parallel.h>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

constexpr double pooled = 2; // widths: h of the weights of anchors that say together whether the surface bends
constexpr double largest_excess = 25;  // of one anchor, over what noise explains
constexpr double doubted_excess = 0.4; // what the mean over a pool reaches by chance
constexpr double farthest = 1.4;       // past the narrower fit, 1; two widths 0.6 apart cancel a kink's bias at 2.5
constexpr double thick = 2.7;          // sigmas: below it the height of a fit is drawn to where it began
constexpr double bent_width = 0.7;     // of the width, over which a corrected anchor is blended with others
constexpr double median_of_squares = 0.455; // of a normal deviate

/// Variance of the difference of the two fits' heights for independent unit noise, times the effective points of the
/// wider one: from the quadric's equivalent kernel (2 - r^2) exp(-r^2) / (pi rho).
double variance_of_difference()
{
    const double b = 1 / (TwoWidths::narrower * TwoWidths::narrower), k = 1 + 1 / b;
    const double covariance = (2 + 2 / (b * k * k)) / (b * k);
    return 2 * b * (1.25 + 1.25 / b - 2 * covariance);
}

} // namespace

void correct_bends(std::vector<Anchor>& anchors, const std::vector<TwoWidths>& fits,
                   const std::vector<FitStart>& starts, int threads)
{
    // Squared differences over what noise explains; how much of it there really is tells their median.
    const std::size_t n = fits.size();
    const double unit = variance_of_difference();
    std::vector<double> excess(n, 0), known;
    for (std::size_t a = 0; a < n; ++a)
    {
        if (!fits[a].comparable)
            continue;
        const double difference = (fits[a].narrow.c[0] - fits[a].wide.c[0]) / starts[a].sigma;
        excess[a] = difference * difference * fits[a].wide.effective / unit;
        known.push_back(excess[a]);
    }
    if (known.empty())
        return;
    const auto middle = known.begin() + std::ptrdiff_t(known.size() / 2);
    std::nth_element(known.begin(), middle, known.end());
    const double share = std::max(*middle / median_of_squares, 1e-12); // of the variance
    std::vector<char> counts(n);
    Points places;
    for (std::size_t a = 0; a < n; ++a)
    {
        counts[a] =
            fits[a].comparable && TwoWidths::narrower * starts[a].width > thick * std::sqrt(share) * starts[a].sigma;
        places.push_back(starts[a].foot);
    }
    const BlockSearch search(places);
    parallel_chunks(n, threads, 256, {},
                    [&](std::size_t begin, std::size_t end)
                    {
                        std::vector<int> near;
                        for (std::size_t a = begin; a < end; ++a)
                        {
                            if (!counts[a])
                                continue;
                            const double width = starts[a].width, reach = pooled * width;
                            search.within(places[a], 2 * reach, near);
                            double total = 0, weights = 0;
                            for (const int i : near)
                            {
                                if (!counts[i] || !(starts[i].normal.dot(starts[a].normal) > 0))
                                    continue;
                                const double weight =
                                    std::exp(-(places[i] - places[a]).squaredNorm() / (reach * reach));
                                total += weight * std::min(excess[i] / share, largest_excess);
                                weights += weight;
                            }
                            const double step = std::clamp(total / weights - 1 - doubted_excess, 0.0, farthest);
                            if (!(step > 0))
                                continue;
                            QuadricFit corrected = fits[a].wide;
                            for (std::size_t k = 0; k < corrected.c.size(); ++k)
                                corrected.c[k] += step * (fits[a].narrow.c[k] - corrected.c[k]);
                            place_anchor(anchors[a], fits[a].position, fits[a].normal, corrected, width);
                            anchors[a].width = width * std::pow(bent_width, std::min(step, 1.0));
                        }
                    });
}

} // namespace recon
