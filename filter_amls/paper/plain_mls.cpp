#include "plain_mls.h"

#include <recon/errors.h>
#include <recon/parallel.h>
#include <recon/search/neighbours.h>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

const double root_of_two = std::sqrt(2.0);

void check(const OrientedSamples& samples, const std::vector<double>& feature_size, const PlainMlsOptions& options)
{
    const auto positive = [](double value) { return value > 0 && std::isfinite(value); };
    if (samples.points.empty() || samples.normals.size() != samples.points.size() ||
        feature_size.size() != samples.points.size())
        throw InvalidInput("The surface needs at least one sample, and a normal and a feature size for each.");
    if (!std::all_of(feature_size.begin(), feature_size.end(), positive))
        throw InvalidInput("A feature size is not a positive number.");
    if (!positive(options.rho_e))
        throw InvalidInput("rho_e must be a positive number; the paper uses 0.75.");
    if (!positive(options.cut_off) || !positive(options.tolerance) || !positive(options.largest_step))
        throw InvalidInput("Cut-off, tolerance and largest step must be positive numbers.");
    if (options.max_iterations < 1)
        throw InvalidInput("The number of iterations must be at least 1.");
}

/// Evaluates the functions at one place and steps towards their zero.
class PlainProjector
{
public:
    PlainProjector(const OrientedSamples& samples, const std::vector<double>& feature_size,
                   const NeighbourSearch& search, double largest_feature, const PlainMlsOptions& options)
        : samples_(samples), feature_size_(feature_size), search_(search), largest_feature_(largest_feature),
          options_(options)
    {
    }

    void project(const Point& start, PlainMlsProjection& result, std::size_t i)
    {
        Point x = start;
        Vector normal = Vector::UnitZ();
        double last = 0; // step before, 0 = none
        result.converged[i] = 0;
        for (int step = 1; step <= options_.max_iterations; ++step)
        {
            result.iterations[i] = step;
            const double f = gather(x);
            Vector move;
            result.neighbours[i] = find_step(x, f, move, normal);
            if (result.neighbours[i] == 0)
            {
                x = start;
                normal = samples_.normals[search_.nearest(start)];
                break;
            }
            const double length = move.norm(), limit = options_.largest_step * f;
            if (!(length <= limit))
                move *= limit / length;
            if (!move.allFinite())
                break;
            x += move;
            const double width = options_.rho_e * f / std::sqrt(root_of_two);
            if (length <= limit && estimate_error(length / width, last) < options_.tolerance)
            {
                result.converged[i] = 1;
                break;
            }
            last = length / width;
        }
        result.points[i] = x;
        result.normals[i] = normal;
    }

private:
    /// Distance to the zero after a step, all in widths. Newton's method leaves half of |I''/I'| times the squared
    /// step, and I's gradient turns by less than itself within a width. VMLS and PMLS, whose n(x) lags behind, leave a
    /// ratio that two steps tell.
    double estimate_error(double step, double last) const
    {
        constexpr double slowest = 0.95;
        if (options_.surface == PlainSurface::normalised || options_.surface == PlainSurface::plain_n)
            return step * step / 2;
        const double ratio = last > 0 ? std::min(step / last, slowest) : slowest;
        return step * ratio / (1 - ratio);
    }

    /// Candidates: what any giver's width may reach. \returns f at x.
    double gather(const Point& x)
    {
        const double f = feature_size_[search_.nearest(x)];
        // Widths vary with the giver; the widest one bounds the search.
        search_.within(x, options_.cut_off * std::sqrt(width_factor() * f * std::min(largest_feature_, 2.25 * f)),
                       candidates_);
        return f;
    }

    /// Squared width of a giver and receiver of feature size 1.
    double width_factor() const { return options_.rho_e * options_.rho_e / root_of_two; }

    /// Calls visit(p, x - p, 1 / squared width, squared distance in widths) for the candidates within the cut-off.
    /// \returns how many there are.
    template <class Visit>
    int visit_samples(const Point& x, double f, const Visit& visit) const
    {
        const double inverse_of_receiver = 1 / (width_factor() * f), limit = options_.cut_off * options_.cut_off;
        int count = 0;
        for (int p : candidates_)
        {
            const Vector u = x - samples_.points[p];
            const double inverse = inverse_of_receiver / feature_size_[p], t = u.squaredNorm() * inverse;
            if (t > limit)
                continue;
            visit(p, u, inverse, t);
            ++count;
        }
        return count;
    }

    /// \returns the number of samples that counted; 0: there is no step.
    int find_step(const Point& x, double f, Vector& move, Vector& normal)
    {
        return options_.surface == PlainSurface::normalised || options_.surface == PlainSurface::plain_n
                   ? find_newton_step(x, f, move, normal)
                   : find_step_along_normal(x, f, move, normal);
    }

    /// Newton's method on N or I = N / W; f at x is taken as locally constant.
    int find_newton_step(const Point& x, double f, Vector& move, Vector& normal) const
    {
        double n = 0, w = 0;
        Vector grad_n = Vector::Zero(), grad_w = Vector::Zero();
        const int count = visit_samples(x, f,
                                        [&](int p, const Vector& u, double inverse, double t)
                                        {
                                            const Vector& v = samples_.normals[p];
                                            const double theta = std::exp(-t), d = u.dot(v);
                                            const Vector grad_theta = -2 * inverse * theta * u;
                                            n += d * theta;
                                            w += theta;
                                            grad_n += theta * v + d * grad_theta;
                                            grad_w += grad_theta;
                                        });
        if (!(w > 0))
            return 0;
        const double value = options_.surface == PlainSurface::normalised ? n / w : n;
        const Vector gradient =
            options_.surface == PlainSurface::normalised ? Vector((grad_n - value * grad_w) / w) : grad_n;
        const double squared = gradient.squaredNorm();
        if (!(squared > 0))
            return 0;
        normal = gradient / std::sqrt(squared);
        move = -value / squared * gradient;
        return count;
    }

    /// VMLS (eq. 8.12) and PMLS (eq. 1.2): n(x) first, so two passes per step.
    int find_step_along_normal(const Point& x, double f, Vector& move, Vector& normal)
    {
        found_.clear();
        Vector mean = Vector::Zero();
        double w = 0;
        visit_samples(x, f,
                      [&](int p, const Vector& u, double inverse, double t)
                      {
                          found_.push_back({u, inverse, std::exp(-t)});
                          mean += found_.back().theta * samples_.normals[p];
                          w += found_.back().theta;
                      });
        const double length = mean.norm();
        if (!(length > 0) || !(w > 0))
            return 0;
        normal = mean / length;
        double g = 0, slope = 0;
        for (const Weighed& sample : found_)
        {
            const double d = sample.from.dot(normal), t = d * d * sample.inverse;
            if (options_.surface == PlainSurface::vmls)
            {
                g += d * sample.theta;
                slope += sample.theta;
            }
            else
            {
                // d/dy of half the sum of d^2 theta along n, and its derivative along n.
                g += d * sample.theta * (1 - t);
                slope += sample.theta * (1 - 5 * t + 2 * t * t);
            }
        }
        if (slope == 0)
            return 0;
        move = -g / slope * normal;
        return int(found_.size());
    }

    /// A sample that counts: its way to x, 1 / squared width and weight.
    struct Weighed
    {
        Vector from;
        double inverse, theta;
    };

    const OrientedSamples& samples_;
    const std::vector<double>& feature_size_;
    const NeighbourSearch& search_;
    double largest_feature_;
    const PlainMlsOptions& options_;
    std::vector<int> candidates_;
    std::vector<Weighed> found_;
};

} // namespace

PlainMlsProjection project_to_plain_mls(const Points& queries, const OrientedSamples& samples,
                                        const std::vector<double>& feature_size, const PlainMlsOptions& options,
                                        const Progress& progress)
{
    check(samples, feature_size, options);
    const int threads = resolve_threads(options.threads);
    const UnitFrame frame(samples.points);
    const UnitFrame queries_frame(queries.empty() ? samples.points : queries); // for its check that they are finite
    OrientedSamples unit{frame.to_unit(samples.points), samples.normals};
    std::vector<double> feature(feature_size.size());
    for (std::size_t i = 0; i < feature.size(); ++i)
        feature[i] = std::min(feature_size[i] / frame.scale(), 1.0);
    const double largest = *std::max_element(feature.begin(), feature.end());
    const NeighbourSearch search(unit.points);

    const std::size_t n = queries.size();
    PlainMlsProjection result;
    result.points = frame.to_unit(queries);
    result.normals.assign(n, Vector::UnitZ());
    result.converged.assign(n, 0);
    result.iterations.assign(n, 0);
    result.neighbours.assign(n, 0);
    parallel_chunks(n, threads, 256, progress,
                    [&](std::size_t begin, std::size_t end)
                    {
                        PlainProjector projector(unit, feature, search, largest, options);
                        for (std::size_t i = begin; i < end; ++i)
                            projector.project(frame.to_unit(queries[i]), result, i);
                    });
    frame.from_unit_in_place(result.points);
    return result;
}

} // namespace recon
