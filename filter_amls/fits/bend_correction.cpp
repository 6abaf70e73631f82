#include "bend_correction.h"

#include "runs.h"

#include <recon/median.h>
#include <recon/parallel.h>
#include <recon/search/block_search.h>
#include <recon/simd.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace recon
{
namespace
{

constexpr double pooled = 2;          // widths: h of the weights of anchors that say together whether the surface bends
constexpr double pool_cut = 2;        // of that h
constexpr double largest_excess = 25; // of one anchor, over what noise explains
constexpr double doubted_excess = 0.4; // what the mean over a pool reaches by chance
constexpr double farthest = 1.4;       // past the narrower fit, 1; two widths 0.6 apart cancel a kink's bias at 2.5
constexpr double thick = 2.7;          // sigmas: below it the height of a fit is drawn to where it began
constexpr double bent_width = 0.7;     // of the width, over which a corrected anchor is blended with others
constexpr double median_of_squares = 0.455; // of a normal deviate
constexpr double run_radius = 0.7;          // widths
constexpr int longest_run = 32;

using Lanes = simd::FloatLanes;

/// Variance of the difference of the two fits' heights for independent unit noise, times the effective points of the
/// wider one: from the quadric's equivalent kernel (2 - r^2) exp(-r^2) / (pi rho).
double variance_of_difference()
{
    const double b = 1 / (TwoWidths::narrower * TwoWidths::narrower), k = 1 + 1 / b;
    const double covariance = (2 + 2 / (b * k * k)) / (b * k);
    return 2 * b * (1.25 + 1.25 / b - 2 * covariance);
}

/// Sums of w excess and w over the anchors with normals in the half space of `normal`, w = exp(-d^2 / reach^2).
RECON_VECTOR_CLONES
void sum_pool(const float* px, const float* py, const float* pz, const float* nx, const float* ny, const float* nz,
              const float* excess, int n, const float* place, const float* normal, float reach, double* sums)
{
    const Lanes zero = {};
    Lanes total = {}, weights = {};
    const float inverse = 1 / (reach * reach);
    for (int i = 0; i < n; i += simd::lane_count)
    {
        const Lanes x = simd::load(px + i) - place[0], y = simd::load(py + i) - place[1],
                    z = simd::load(pz + i) - place[2];
        const Lanes e = (x * x + y * y + z * z) * inverse;
        const Lanes facing =
            simd::load(nx + i) * normal[0] + simd::load(ny + i) * normal[1] + simd::load(nz + i) * normal[2];
        Lanes w = e <= float(pool_cut * pool_cut) ? simd::exp_negative(e) : zero;
        w = facing > zero ? w : zero;
        total += w * simd::load(excess + i);
        weights += w;
    }
    sums[0] = simd::sum(total);
    sums[1] = simd::sum(weights);
}

/// Moves an anchor `step` of the way from the wider fit to the narrower one.
void correct(Anchor& anchor, const TwoWidths& fits, double step, double width)
{
    QuadricFit corrected = fits.wide;
    for (std::size_t k = 0; k < corrected.c.size(); ++k)
        corrected.c[k] += step * (fits.narrow.c[k] - corrected.c[k]);
    place_anchor(anchor, fits.position, fits.frame, corrected, width);
    anchor.width = width * std::pow(bent_width, std::min(step, 1.0));
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
    const double share = std::max(median(std::move(known)) / median_of_squares, 1e-12); // of the variance
    std::vector<int> asked;
    Points places;
    Vectors normals;
    for (std::size_t a = 0; a < n; ++a)
    {
        excess[a] = std::min(excess[a] / share, largest_excess);
        if (!fits[a].comparable || TwoWidths::narrower * starts[a].width <= thick * std::sqrt(share) * starts[a].sigma)
            continue;
        asked.push_back(int(a));
        places.push_back(starts[a].foot);
        normals.push_back(starts[a].normal);
    }
    const BlockSearch search(places, threads);
    const std::vector<Run> runs =
        split_into_runs(places, longest_run, [&](int i) { return run_radius * starts[asked[i]].width; });
    parallel_chunks(runs.size(), threads, 64, {},
                    [&](std::size_t begin, std::size_t end)
                    {
                        std::vector<int> near;
                        std::vector<float> near_excess;
                        Gathered pool;
                        for (std::size_t r = begin; r < end; ++r)
                        {
                            const Run& run = runs[r];
                            double widest = 0;
                            for (int i = run.begin; i < run.end; ++i)
                                widest = std::max(widest, starts[asked[i]].width);
                            search.within(run.centre, run.radius + pool_cut * pooled * widest, near);
                            pool.gather(places, {}, near, run.centre);
                            pool.gather_directions(normals, near);
                            near_excess.assign(pool.x.size(), 0);
                            for (std::size_t k = 0; k < near.size(); ++k)
                                near_excess[k] = float(excess[asked[near[k]]]);
                            for (int i = run.begin; i < run.end; ++i)
                            {
                                const int a = asked[i];
                                const double width = starts[a].width;
                                const Eigen::Vector3f place = (places[i] - run.centre).cast<float>(),
                                                      normal = normals[i].cast<float>();
                                double sums[2];
                                sum_pool(pool.x.data(), pool.y.data(), pool.z.data(), pool.nx.data(), pool.ny.data(),
                                         pool.nz.data(), near_excess.data(), pool.size, place.data(), normal.data(),
                                         float(pooled * width), sums);
                                const double step = std::clamp(sums[0] / sums[1] - 1 - doubted_excess, 0.0, farthest);
                                if (step > 0)
                                    correct(anchors[a], fits[a], step, width);
                            }
                        }
                    });
}

} // namespace recon
