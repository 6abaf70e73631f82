#include "local_scales.h"

#include "alike_noise.h"
#include "weighted_sums.h"

#include <recon/parallel.h>
#include <recon/search/block_search.h>
#include <recon/search/neighbours.h>
#include <recon/simd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace recon
{
namespace
{

using simd::Lanes;

constexpr double pi = 3.14159265358979323846;
constexpr int ladder = 7;
constexpr double rung = 1.27;            // ratio of widths; 1.6 times the points
constexpr double fewest_points = 16;     // effective points at the narrowest width
constexpr double narrowest_sigmas = 1.5; // below it the neighbourhood is thicker than wide
constexpr double quadric_cut = 2.6;      // widths
constexpr double largest_step = 5;       // sigmas by which two heights differ at most
constexpr int pooled_seeds = 25;
constexpr double global_share = 0.3; // weight of the mean over all seeds alike beside the pooled ones
constexpr int smoothing_seeds = 15;
constexpr double seed_reach = 0.3; // of the distance of close seeds
constexpr double widest = 0.15;    // diagonals: more takes in the whole shape, as it would in clouds of few points
constexpr double affordable = 600; // points per seed; beyond it fewer seeds are asked
constexpr double beyond = 1e10;    // coordinate of entries that pad the arrays
/// The noise estimate means the length; here an estimate that is high by 10 % hides as much bias, so it is taken lower.
constexpr double caution = 0.88;
/// A cloud without noise still needs a unit in which to weigh the bias [share of the spacing].
constexpr double least_sigma = 0.01;

/// Writes l = w (1, u, v, uu, uv, vv) . coefficients and returns {sum l z, sum l^2, sum l l0}.
RECON_VECTOR_CLONES
void sum_smoother(const double* pu, const double* pv, const double* pz, int n, double width, double cut,
                  const double* coefficients, const double* reference, double* l, double* sums)
{
    const double inverse = 1 / width, limit = cut * cut;
    Lanes height = {}, square = {}, product = {};
    for (int i = 0; i < n; i += simd::lane_count)
    {
        const Lanes u = simd::load(pu + i) * inverse, v = simd::load(pv + i) * inverse, z = simd::load(pz + i);
        const Lanes e = u * u + v * v + (z * inverse) * (z * inverse);
        const Lanes w = simd::where_at_most(e, limit - Lanes{}, simd::exp_negative(e), simd::zero());
        const Lanes value = w * (coefficients[0] + coefficients[1] * u + coefficients[2] * v + coefficients[3] * u * u +
                                 coefficients[4] * u * v + coefficients[5] * v * v);
        simd::store(l + i, value);
        height += value * z;
        square += value * value;
        product += value * simd::load(reference + i);
    }
    sums[0] = simd::sum(height);
    sums[1] = simd::sum(square);
    sums[2] = simd::sum(product);
}

/// Sums of w times the monomials up to the fourth degree.
RECON_VECTOR_CLONES
void sum_monomials(const double* pu, const double* pv, const double* pz, int n, double width, double cut, double* sums)
{
    const double inverse = 1 / width, limit = cut * cut;
    Lanes total[15] = {};
    for (int i = 0; i < n; i += simd::lane_count)
    {
        const Lanes u = simd::load(pu + i) * inverse, v = simd::load(pv + i) * inverse,
                    z = simd::load(pz + i) * inverse;
        const Lanes e = u * u + v * v + z * z;
        const Lanes w = simd::where_at_most(e, limit - Lanes{}, simd::exp_negative(e), simd::zero());
        const Lanes wu = w * u, wv = w * v, wuu = wu * u, wuv = wu * v, wvv = wv * v;
        total[0] += w;
        total[1] += wu;
        total[2] += wv;
        total[3] += wuu;
        total[4] += wuv;
        total[5] += wvv;
        total[6] += wuu * u;
        total[7] += wuu * v;
        total[8] += wvv * u;
        total[9] += wvv * v;
        total[10] += wuu * u * u;
        total[11] += wuu * u * v;
        total[12] += wuu * v * v;
        total[13] += wvv * u * v;
        total[14] += wvv * v * v;
    }
    for (int k = 0; k < 15; ++k)
        sums[k] = simd::sum(total[k]);
}

using Risks = std::array<double, ladder>;

/// Risk of each candidate at one seed, in units of the noise's variance.
class RiskEstimator
{
public:
    /// \param samples with sides, or without weights and normals.
    RiskEstimator(const FitSamples& samples, double clearance) : samples_(samples), clearance_(clearance) {}

    /// \param facing normal at the seed; not used if the samples have no sides.
    Risks estimate(const Point& seed, const Vector& facing, double sigma, double narrowest)
    {
        std::array<double, ladder> widths;
        for (int j = 0; j < ladder; ++j)
            widths[j] = narrowest * std::pow(rung, j);
        Risks risks{};
        samples_.search.within(seed, quadric_cut * widths[ladder - 1] + 2 * sigma, found_);
        if (!samples_.normals.empty())
            leave_out_others(seed, facing, narrowest);
        gathered_.gather(samples_.points, {}, found_, seed);

        Point centre = Point::Zero();
        Vector normal = Vector::UnitZ();
        const double width = widths[2];
        for (int i = 0; i < 2; ++i)
        {
            const WeightedPlane plane = fit_plane(gathered_, centre, width, quadric_cut);
            normal = plane.normal;
            centre += normal * normal.dot(plane.mean - centre);
        }
        const TangentFrame first(normal);
        const QuadricFit fit = fit_quadric(gathered_, centre, first, {width, quadric_cut});
        if (fit.valid)
        {
            centre += fit.c[0] * normal;
            normal = normal_of(fit, first, width);
        }
        const TangentFrame frame(normal);
        sort_by_ring(centre, frame, widths);

        double height0 = 0, square0 = 0;
        for (int j = 0; j < ladder; ++j)
        {
            double sums[3];
            if (!smooth(widths[j], ring_end_[j], sums))
            {
                // Too few points for a quadric: no bias can be told, the variance is that of a single point.
                risks[j] = 1;
                continue;
            }
            if (j == 0)
            {
                l0_.swap(l_);
                height0 = sums[0];
                square0 = sums[1];
                risks[0] = square0;
                continue;
            }
            const double step = std::clamp((sums[0] - height0) / (caution * sigma), -largest_step, largest_step);
            risks[j] = step * step - (sums[1] - 2 * sums[2] + square0) + sums[1];
        }
        return risks;
    }

private:
    /// Leaves what counts in a fit, unless others are so near that no window would see that the surface bends to them.
    void leave_out_others(const Point& seed, const Vector& facing, double narrowest)
    {
        const auto is_other = [&](int i)
        { return samples_.weights[i] == 0 || samples_.normals[i].dot(facing) <= facing_cosine; };
        const double reach = clearance_ * narrowest;
        const auto is_near_other = [&](int i)
        { return (samples_.points[i] - seed).squaredNorm() < reach * reach && is_other(i); };
        if (std::none_of(found_.begin(), found_.end(), is_near_other))
            found_.erase(std::remove_if(found_.begin(), found_.end(), is_other), found_.end());
    }

    /// Coordinates in the frame, the points of the narrowest candidate first, those that each wider one adds after
    /// them.
    void sort_by_ring(const Point& centre, const TangentFrame& frame, const std::array<double, ladder>& widths)
    {
        const std::size_t padded = gathered_.x.size();
        u_.assign(padded, beyond);
        for (auto* values : {&v_, &z_, &l_, &l0_})
            values->assign(padded, 0);
        ring_.resize(padded);
        std::array<int, ladder + 1> count{};
        for (int i = 0; i < gathered_.size; ++i)
        {
            const double squared = (Point(gathered_.x[i], gathered_.y[i], gathered_.z[i]) - centre).squaredNorm();
            int j = 0;
            while (j < ladder && squared > quadric_cut * quadric_cut * widths[j] * widths[j])
                ++j;
            ring_[i] = j;
            ++count[j];
        }
        std::array<int, ladder + 1> next{};
        for (int j = 0; j < ladder; ++j)
        {
            next[j + 1] = next[j] + count[j];
            ring_end_[j] = next[j + 1];
        }
        for (int i = 0; i < gathered_.size; ++i)
        {
            const Vector d = Point(gathered_.x[i], gathered_.y[i], gathered_.z[i]) - centre;
            const int to = next[ring_[i]]++;
            u_[to] = d.dot(frame.t1);
            v_[to] = d.dot(frame.t2);
            z_[to] = d.dot(frame.normal);
        }
    }

    /// \returns {height at the foot, sum l^2, sum l l0} of the quadric smoother; fills l_.
    bool smooth(double width, int n, double* sums)
    {
        double s[15];
        sum_monomials(u_.data(), v_.data(), z_.data(), n, width, quadric_cut, s);
        if (!(s[0] > 0))
            return false;
        Eigen::Matrix<double, 6, 6> m;
        m << s[0], s[1], s[2], s[3], s[4], s[5],   //
            s[1], s[3], s[4], s[6], s[7], s[8],    //
            s[2], s[4], s[5], s[7], s[8], s[9],    //
            s[3], s[6], s[7], s[10], s[11], s[12], //
            s[4], s[7], s[8], s[11], s[12], s[13], //
            s[5], s[8], s[9], s[12], s[13], s[14];
        for (int k = 1; k < 6; ++k)
            m(k, k) += (k < 3 ? 1e-4 : 2e-3) * s[0];
        const SmallCholesky<6> cholesky(m);
        if (!cholesky.valid())
            return false;
        const Eigen::Matrix<double, 6, 1> c = cholesky.solve(Eigen::Matrix<double, 6, 1>::Unit(0));
        sum_smoother(u_.data(), v_.data(), z_.data(), n, width, quadric_cut, c.data(), l0_.data(), l_.data(), sums);
        return std::isfinite(sums[0]) && std::isfinite(sums[1]);
    }

    const FitSamples& samples_;
    double clearance_;
    std::vector<int> found_;
    Gathered gathered_;
    std::vector<double> u_, v_, z_, l_, l0_;
    std::vector<int> ring_;
    std::array<int, ladder> ring_end_{};
};

/// In spacings.
double relative_noise(const LocalScale& scale)
{
    return scale.sigma * std::sqrt(scale.density);
}

/// Position of the minimum on the ladder, between the rungs by a parabola.
double find_minimum(const Risks& risks)
{
    const int j = int(std::min_element(risks.begin(), risks.end()) - risks.begin());
    if (j == 0 || j == ladder - 1)
        return j;
    const double left = risks[j - 1], right = risks[j + 1], bend = left - 2 * risks[j] + right;
    return bend > 0 ? j + std::clamp(0.5 * (left - right) / bend, -0.5, 0.5) : j;
}

/// \param facing normals, one per seed; empty if the samples have no sides.
LocalScales choose_least_risk(const FitSamples& samples, const Vectors& facing, const NoiseEstimate& noise,
                              double clearance, int threads, const Progress& progress)
{
    const int m = noise.size();
    LocalScales result{noise, std::vector<LocalScale>(m), 0};
    std::vector<double> narrowest(m);
    double expected = 0;
    for (int i = 0; i < m; ++i)
    {
        LocalScale& scale = result.at_seed[i];
        scale.density = noise.density()[i];
        scale.sigma = std::max(noise.sigma()[i], least_sigma / std::sqrt(scale.density));
        narrowest[i] = std::max(std::sqrt(fewest_points / (2 * pi * scale.density)), narrowest_sigmas * scale.sigma);
        const double radius = quadric_cut * narrowest[i] * std::pow(rung, ladder - 1);
        expected += pi * radius * radius * scale.density / m;
    }

    // Risks are pooled anyway, so where seeds are expensive fewer of them do.
    const int stride = std::clamp(int(std::lround(expected / affordable)), 1, 8);
    Points asked;
    std::vector<int> asked_index;
    for (int i = stride / 2; i < m; i += stride)
    {
        asked.push_back(noise.seeds()[i]);
        asked_index.push_back(i);
    }
    std::vector<Risks> risks(asked.size());
    parallel_chunks(asked.size(), threads, 16, progress,
                    [&](std::size_t begin, std::size_t end)
                    {
                        RiskEstimator estimator(samples, clearance);
                        for (std::size_t i = begin; i < end; ++i)
                        {
                            const int s = asked_index[i];
                            risks[i] = estimator.estimate(asked[i], facing.empty() ? Vector::Zero() : facing[s],
                                                          result.at_seed[s].sigma, narrowest[s]);
                        }
                    });

    std::vector<double> asked_noise;
    for (const int i : asked_index)
        asked_noise.push_back(relative_noise(result.at_seed[i]));
    const AlikeMeans<ladder> alike(asked_noise, risks, 1);
    const NeighbourSearch asked_search(asked), seed_search(noise.seeds());
    std::vector<double> log_width(m), distance(m);
    parallel_for(std::size_t(m), threads, {},
                 [&](std::size_t i)
                 {
                     int near[pooled_seeds];
                     double squared[pooled_seeds];
                     const int count = asked_search.nearest(noise.seeds()[i], pooled_seeds, near, squared);
                     Risks pooled = alike.around(relative_noise(result.at_seed[i]));
                     for (double& risk : pooled)
                         risk *= global_share * count;
                     for (int k = 0; k < count; ++k)
                         if (is_alike_noise(result.at_seed[i].sigma, result.at_seed[asked_index[near[k]]].sigma))
                             for (int j = 0; j < ladder; ++j)
                                 pooled[j] += risks[near[k]][j];
                     log_width[i] = std::log(narrowest[i]) + find_minimum(pooled) * std::log(rung);
                 });
    parallel_for(std::size_t(m), threads, {},
                 [&](std::size_t i)
                 {
                     int near[smoothing_seeds];
                     double squared[smoothing_seeds];
                     const int count = seed_search.nearest(noise.seeds()[i], smoothing_seeds, near, squared);
                     double total = 0;
                     int alike_seeds = 0; // the seed itself at least
                     for (int k = 0; k < count; ++k)
                         if (is_alike_noise(result.at_seed[i].sigma, result.at_seed[near[k]].sigma))
                         {
                             total += log_width[near[k]];
                             ++alike_seeds;
                         }
                     result.at_seed[i].width = std::min(std::exp(total / alike_seeds), widest);
                     distance[i] = std::sqrt(squared[std::min(1, count - 1)]);
                 });
    const auto close = distance.begin() + std::ptrdiff_t(distance.size() / 10);
    std::nth_element(distance.begin(), close, distance.end());
    result.seed_reach = seed_reach * *close;
    return result;
}

} // namespace

LocalScales choose_widths(const Points& points, const BlockSearch& search, const NoiseEstimate& noise, int threads,
                          const Progress& progress)
{
    return choose_least_risk({points, search, {}, {}}, {}, noise, 0, threads, progress);
}

LocalScales choose_fit_widths(const FitSamples& samples, const Vectors& normals, const NoiseEstimate& noise,
                              double clearance, int threads, const Progress& progress)
{
    return choose_least_risk(samples, normals, noise, clearance, threads, progress);
}

} // namespace recon
