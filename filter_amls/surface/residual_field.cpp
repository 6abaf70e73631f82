#include "residual_field.h"

#include "filter_amls/fits/alike_noise.h"
#include "filter_amls/fits/runs.h"
#include "filter_amls/fits/weighted_sums.h"
#include "surface_data.h"

#include <recon/parallel.h>
#include <recon/scramble.h>
#include <recon/simd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace recon
{
namespace
{

/// Of the passes [widths]: more samples tell weaker errors, fewer those that change sooner.
constexpr std::array<double, 2> windows = {0.55, 0.4};
constexpr double window_cut = 1.7;    // windows
constexpr double least_cosine = 0.7;  // of the normals of samples that tell the error of a place with its own
constexpr double largest_error = 0.7; // sigmas
constexpr std::array<double, 3> robust_scales = {0.07, 0.1, 0.2};  // sigmas: the candidates
constexpr std::array<double, 4> narrowing_rounds = {2, 1.4, 1, 1}; // robust scales
/// Two halves of the samples agree less than all of them tell, so that half of what is told need not be confirmed.
constexpr double confirmed_share = 0.4;
constexpr int points_per_trial = 25, fewest_trials = 1000, most_trials = 4000;
constexpr int pooled_trials = 40, global_trials = 40; // trials around that share their verdict, and the weight of all
constexpr double run_radius = 0.5;                    // widths
constexpr int longest_run = 64;

using Lanes = simd::FloatLanes;

/// Weights exp(-d^2 / window^2) of samples about a place, those that face elsewhere and those beyond the cut 0.
RECON_VECTOR_CLONES
void weigh(const Gathered& around, const float* place, const float* normal, float inverse_window, float* weights)
{
    const Lanes zero = {};
    const float cut = float(window_cut * window_cut);
    for (int i = 0; i < around.size; i += simd::lane_count)
    {
        const Lanes x = simd::load(&around.x[std::size_t(i)]) - place[0],
                    y = simd::load(&around.y[std::size_t(i)]) - place[1],
                    z = simd::load(&around.z[std::size_t(i)]) - place[2];
        const Lanes facing = simd::load(&around.nx[std::size_t(i)]) * normal[0] +
                             simd::load(&around.ny[std::size_t(i)]) * normal[1] +
                             simd::load(&around.nz[std::size_t(i)]) * normal[2];
        const Lanes e = (x * x + y * y + z * z) * (inverse_window * inverse_window);
        Lanes w = e <= cut ? simd::exp_negative(e) : zero;
        w = facing > float(least_cosine) ? w : zero;
        std::memcpy(weights + i, &w, sizeof w);
    }
}

/// Sums of theta r and theta, theta = w (1 + ((r - centre) / 2 s)^2)^-2.
RECON_VECTOR_CLONES
void sum_robust(const float* weights, const float* residuals, int n, float centre, float inverse_scale, double* sums)
{
    Lanes total = {}, mass = {};
    for (int i = 0; i < n; i += simd::lane_count)
    {
        const Lanes r = simd::load(residuals + i), off = (r - centre) * inverse_scale;
        const Lanes near = 1.0f / (1.0f + off * off);
        const Lanes w = simd::load(weights + i) * near * near;
        total += w * r;
        mass += w;
    }
    sums[0] = simd::sum(total);
    sums[1] = simd::sum(mass);
}

/// What samples say that the surface errs at a place.
class ErrorTeller
{
public:
    explicit ErrorTeller(const ResidualField& field) : field_(field) {}

    /// Makes the samples around a ball of places ready.
    void prepare(const Point& centre, double radius)
    {
        field_.search.within(centre, radius, found_);
        around_.gather(field_.places, {}, found_, centre);
        around_.gather_directions(field_.normals, found_);
        residuals_.assign(around_.x.size(), 0);
        for (std::size_t k = 0; k < found_.size(); ++k)
            residuals_[k] = field_.residuals[std::size_t(found_[k])];
        weights_.resize(around_.x.size());
        origin_ = centre;
    }

    /// Chooses those about a place.
    void look_at(const Point& place, const Vector& normal, double width)
    {
        const Eigen::Vector3f local = (place - origin_).cast<float>(), n = normal.cast<float>();
        weigh(around_, local.data(), n.data(), float(1 / (field_.window * width)), weights_.data());
    }

    /// What they say [length]. \param scale the robust scale [sigma].
    double error_by_all(double sigma, double scale) const { return error(weights_, sigma, scale); }

    /// Divides them, at random: neighbours in spatial order are off alike, so that taking turns the halves would agree
    /// on noise.
    void divide()
    {
        for (auto& half : half_weights_)
            half.assign(weights_.size(), 0);
        for (std::size_t k = 0; k < found_.size(); ++k)
            half_weights_[mix_bits(std::uint64_t(found_[k])) & 1][k] = weights_[k];
    }
    double error_by_half(int half, double sigma, double scale) const
    {
        return error(half_weights_[std::size_t(half)], sigma, scale);
    }

private:
    double error(const std::vector<float>& weights, double sigma, double scale) const
    {
        double centre = 0;
        for (const double factor : narrowing_rounds)
        {
            double sums[2];
            sum_robust(weights.data(), residuals_.data(), around_.size, float(centre),
                       float(1 / (2 * factor * scale * sigma)), sums);
            if (!(sums[1] > 0))
                return 0;
            centre = sums[0] / sums[1];
        }
        return std::clamp(centre, -largest_error * sigma, largest_error * sigma);
    }

    const ResidualField& field_;
    std::vector<int> found_;
    Gathered around_;
    std::vector<float> residuals_, weights_;
    std::array<std::vector<float>, 2> half_weights_;
    Point origin_ = Point::Zero();
};

/// Errors at a place: the product of what two halves say, whose mean is the square of the true error, and the square of
/// what all say, per candidate of the robust scale [sigma^2].
struct Trial
{
    std::array<double, robust_scales.size()> agreed{}, told{};
};

double believed_share(double agreed, double told)
{
    return told > 0 ? std::clamp(agreed / (confirmed_share * told), 0.0, 1.0) : 0;
}

ResidualField list_residuals(const AmlsSurface::Data& data, const AmlsProjection& projected,
                             const std::vector<int>& moved, int threads)
{
    ResidualField field;
    field.places.resize(moved.size());
    field.normals.resize(moved.size());
    field.residuals.resize(moved.size());
    parallel_for(
        moved.size(), threads, {},
        [&](std::size_t m)
        {
            const std::size_t i = std::size_t(moved[m]);
            field.places[m] = projected.points[i];
            field.normals[m] = projected.normals[i];
            field.residuals[m] = float((data.points[i] - projected.points[i]).dot(projected.normals[i]));
        },
        4096);
    field.search = BlockSearch(field.places, threads);
    return field;
}

std::vector<Trial> run_trials(const AmlsSurface::Data& data, const ResidualField& field, const TrialPlaces& places,
                              int threads)
{
    std::vector<Trial> trials(places.count);
    parallel_chunks(places.count, threads, 16, {},
                    [&](std::size_t begin, std::size_t end)
                    {
                        ErrorTeller teller(field);
                        for (std::size_t t = begin; t < end; ++t)
                        {
                            const std::size_t i = t * places.stride;
                            const LocalScale& scale =
                                data.cells.scales[std::size_t(data.cells.cell_of_point[std::size_t(places.moved[i])])];
                            teller.prepare(field.places[i], window_cut * field.window * scale.width);
                            teller.look_at(field.places[i], field.normals[i], scale.width);
                            teller.divide();
                            for (std::size_t k = 0; k < robust_scales.size(); ++k)
                            {
                                const auto by_half = [&](int half)
                                { return teller.error_by_half(half, scale.sigma, robust_scales[k]) / scale.sigma; };
                                const double all = teller.error_by_all(scale.sigma, robust_scales[k]) / scale.sigma;
                                trials[t].agreed[k] = by_half(0) * by_half(1);
                                trials[t].told[k] = all * all;
                            }
                        }
                    });
    return trials;
}

/// The candidate by which most of the error can be taken back.
std::size_t choose_best_scale(const std::vector<Trial>& trials)
{
    std::size_t best = 0;
    double best_gain = 0;
    for (std::size_t k = 0; k < robust_scales.size(); ++k)
    {
        double a = 0, b = 0;
        for (const Trial& trial : trials)
        {
            a += trial.agreed[k] / double(trials.size());
            b += trial.told[k] / double(trials.size());
        }
        const double gain = a > 0 ? a * a / b : 0;
        if (k == 0 || gain > best_gain)
        {
            best = k;
            best_gain = gain;
        }
    }
    return best;
}

/// What share of the error told around each trial is true, by those in alike noise: near by and, for less, all.
std::vector<float> list_shares(const std::vector<Trial>& trials, const TrialPlaces& places, std::size_t candidate)
{
    std::vector<std::array<double, 2>> known;
    for (const Trial& trial : trials)
        known.push_back({trial.agreed[candidate], trial.told[candidate]});
    const AlikeMeans<2> alike(places.sigma, known, global_trials);
    std::vector<float> shares(trials.size());
    for (std::size_t t = 0; t < trials.size(); ++t)
    {
        const auto usual = alike.around(places.sigma[t]);
        double a = global_trials * usual[0], b = global_trials * usual[1];
        for (std::size_t k = 0; k < places.pooled; ++k)
        {
            const std::size_t near = std::size_t(places.near[t * places.pooled + k]);
            if (!is_alike_noise(places.sigma[t], places.sigma[near]))
                continue;
            a += known[near][0];
            b += known[near][1];
        }
        shares[t] = float(believed_share(a, b));
    }
    return shares;
}

} // namespace

TrialPlaces::TrialPlaces(const AmlsSurface::Data& data, const AmlsProjection& projected, int threads)
{
    for (std::size_t i = 0; i < projected.points.size(); ++i)
        if (is_moved(projected.status[i]))
            moved.push_back(int(i));
    const std::size_t n = moved.size();
    const std::size_t wanted = std::clamp<std::size_t>(n / points_per_trial, fewest_trials, most_trials);
    stride = std::max<std::size_t>(1, n / wanted);
    count = (n + stride - 1) / stride;
    pooled = std::min<std::size_t>(count, pooled_trials);
    if (count == 0)
        return;
    Points places;
    for (std::size_t i = 0; i < n; i += stride)
        places.push_back(projected.points[std::size_t(moved[i])]);
    const BlockSearch search(places, threads);
    near.resize(count * pooled);
    parallel_for(
        count, threads, {},
        [&](std::size_t t)
        {
            double squared[pooled_trials];
            search.nearest(places[t], int(pooled), &near[t * pooled], squared);
        },
        64);
    for (std::size_t t = 0; t < count; ++t)
        sigma.push_back(data.cells.scales[std::size_t(data.cells.cell_of_point[std::size_t(moved[t * stride])])].sigma);
    of_cell.resize(std::size_t(data.cells.size()));
    parallel_for(
        of_cell.size(), threads, {}, [&](std::size_t c) { of_cell[c] = search.nearest(data.cells.means[c]); }, 1024);
}

ResidualField measure_residuals(const AmlsSurface::Data& data, const AmlsProjection& projected,
                                const TrialPlaces& places, double window, int threads)
{
    ResidualField field = list_residuals(data, projected, places.moved, threads);
    field.window = window;
    const std::vector<Trial> trials = run_trials(data, field, places, threads);
    const std::size_t candidate = choose_best_scale(trials);
    field.robust_scale = robust_scales[candidate];
    const std::vector<float> shares = list_shares(trials, places, candidate);
    if (std::all_of(shares.begin(), shares.end(), [](float share) { return share == 0; }))
        return {};
    for (const int t : places.of_cell)
        field.shares.push_back(shares[std::size_t(t)]);
    return field;
}

void correct_by_residuals(const AmlsSurface::Data& data, const ResidualField& field, const std::vector<int>& cells,
                          AmlsProjection& projected, int threads, const Progress& progress)
{
    if (field.empty())
        return;
    const std::vector<Run> runs = split_into_runs(
        projected.points, longest_run,
        [&](int i) { return run_radius * data.cells.scales[std::size_t(cells[std::size_t(i)])].width; });
    visit_runs(
        runs, threads, progress, [&] { return ErrorTeller(field); },
        [&](ErrorTeller& teller, const Run& run)
        {
            const double width = largest_in(
                run, [&](int i) { return field.shares[cells[i]] > 0 ? data.cells.scales[cells[i]].width : 0; });
            if (width == 0)
                return;
            teller.prepare(run.centre, run.radius + window_cut * field.window * width);
            for (int i = run.begin; i < run.end; ++i)
            {
                const float share = field.shares[cells[i]];
                if (share == 0 || !is_moved(projected.status[i]))
                    continue;
                const LocalScale& scale = data.cells.scales[cells[i]];
                teller.look_at(projected.points[i], projected.normals[i], scale.width);
                projected.points[i] +=
                    share * teller.error_by_all(scale.sigma, field.robust_scale) * projected.normals[i];
            }
        });
}

std::vector<ResidualField> measure_residuals_in_passes(const AmlsSurface::Data& data, AmlsProjection& projected,
                                                       int threads)
{
    std::vector<ResidualField> fields;
    const TrialPlaces places(data, projected, threads);
    for (const double window : windows)
    {
        ResidualField field = measure_residuals(data, projected, places, window, threads);
        if (field.empty())
            break;
        correct_by_residuals(data, field, data.cells.cell_of_point, projected, threads);
        fields.push_back(std::move(field));
    }
    return fields;
}

} // namespace recon
