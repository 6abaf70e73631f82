#include "fit.h"

#include "bend_correction.h"
#include "runs.h"
#include "weighted_sums.h"

#include <recon/block_search.h>
#include <recon/parallel.h>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

constexpr double least_cosine = 0.35; // of the directions of samples that count with the normal to begin with
/// Rounds of fitting. Where few good points decide, weights need rounds to find them; else more only add variance.
constexpr int few_rounds = 2, many_rounds = 4, narrow_rounds = 2;
constexpr double least_points = 12;  // effective points of a fit worth comparing
constexpr double largest_turn = 0.5; // cosine
constexpr double largest_move = 0.4; // widths
constexpr double largest_move_sigmas = 2.5;
constexpr double enough_points = 60;  // more effective points do not raise the confidence
constexpr double doubtful_move = 0.5; // widths
constexpr double run_radius = 0.7;    // widths
constexpr int longest_run = 32;

std::array<double, 6> bending_of(const QuadricFit& fit, double width, const TangentFrame& frame)
{
    const double uu = fit.c[3] / (width * width), uv = fit.c[4] / (width * width), vv = fit.c[5] / (width * width);
    const Eigen::Matrix3d q = uu * frame.t1 * frame.t1.transpose() + vv * frame.t2 * frame.t2.transpose() +
                              0.5 * uv * (frame.t1 * frame.t2.transpose() + frame.t2 * frame.t1.transpose());
    return {q(0, 0), q(1, 1), q(2, 2), q(0, 1), q(0, 2), q(1, 2)};
}

QuadricFit in_units(QuadricFit fit, double ratio)
{
    for (int k = 1; k < 6; ++k)
        fit.c[k] *= k < 3 ? ratio : ratio * ratio;
    return fit;
}

/// The quadric over the narrower width in the same frame, robust about `about` first and then about itself.
QuadricFit fit_narrower(const Gathered& gathered, const Point& position, const TangentFrame& frame, QuadricWeights how,
                        const QuadricFit& about)
{
    how.width *= TwoWidths::narrower;
    QuadricFit fit = in_units(about, TwoWidths::narrower);
    for (int round = 0; round < narrow_rounds && fit.valid; ++round)
    {
        const QuadricFit previous = fit;
        how.robust_about = &previous;
        fit = fit_quadric(gathered, position, frame, how);
    }
    return in_units(fit, 1 / TwoWidths::narrower);
}

/// Fits anchors one after the other; holds the samples last gathered.
class AnchorFitter
{
public:
    AnchorFitter(const FitSamples& samples, double robust_scale) : samples_(samples), robust_scale_(robust_scale) {}

    /// Makes the samples around a run of anchors ready.
    void prepare(const Point& centre, double radius)
    {
        samples_.search.within(centre, radius, found_);
        around_run_.gather(samples_.points, samples_.weights, found_, centre);
        around_run_.gather_directions(samples_.normals, found_);
        origin_ = centre;
    }

    Anchor fit(const FitStart& start, TwoWidths& two)
    {
        const double width = start.width;
        Anchor anchor{start.foot, start.normal, {}, 0, width};
        Point position = start.foot - origin_;
        Vector direction = start.normal;
        around_.gather_facing(around_run_, position, fit_cut * width, direction, least_cosine);
        QuadricWeights how{width, fit_cut};
        how.robust_scale = robust_scale_ * start.sigma;
        const int rounds = robust_scale_ < picky_scale ? many_rounds : few_rounds;
        QuadricFit fit = fit_quadric(around_, position, TangentFrame(direction), how);
        const double plane_confidence = std::min(fit.effective, enough_points);
        if (!fit.valid)
        {
            anchor.confidence = std::min(fit.effective, 1.0);
            return anchor;
        }
        for (int round = 1;; ++round)
        {
            const TangentFrame frame(direction);
            position += fit.c[0] * direction;
            direction = (direction - fit.c[1] / width * frame.t1 - fit.c[2] / width * frame.t2).normalized();
            // The surface seen from the frame moved and turned to it: neither offset nor slope are left.
            QuadricFit moved = fit;
            moved.c[0] = moved.c[1] = moved.c[2] = 0;
            how.robust_about = &moved;
            const TangentFrame turned(direction);
            const QuadricFit next = fit_quadric(around_, position, turned, how);
            if (!next.valid)
            {
                fit = moved;
                break;
            }
            fit = next;
            if (round + 1 < rounds)
                continue;
            two.narrow = fit_narrower(around_, position, turned, how, moved);
            two.wide = fit;
            two.comparable = two.narrow.valid && two.narrow.effective > least_points;
            break;
        }
        two.position = position + origin_;
        two.normal = direction;
        place_anchor(anchor, two.position, two.normal, fit, width);
        const double moved = (anchor.position - start.foot).norm();
        if (!anchor.position.allFinite() || !anchor.normal.allFinite() ||
            anchor.normal.dot(start.normal) < largest_turn ||
            moved > std::max(largest_move * width, largest_move_sigmas * start.sigma))
        {
            two.comparable = false;
            return {start.foot, start.normal, {}, plane_confidence, width};
        }
        const double doubt = moved / (doubtful_move * width);
        anchor.confidence = std::min(fit.effective, enough_points) * std::exp(-doubt * doubt);
        return anchor;
    }

private:
    const FitSamples& samples_;
    double robust_scale_;
    std::vector<int> found_;
    Gathered around_run_, around_;
    Point origin_ = Point::Zero();
};

} // namespace

void place_anchor(Anchor& anchor, const Point& position, const Vector& normal, const QuadricFit& fit, double width)
{
    const TangentFrame frame(normal);
    anchor.position = position + fit.c[0] * normal;
    anchor.normal = (normal - fit.c[1] / width * frame.t1 - fit.c[2] / width * frame.t2).normalized();
    anchor.bending = bending_of(fit, width, frame);
}

std::vector<Anchor> fit_anchors(const FitSamples& samples, const std::vector<FitStart>& starts, double robust_scale,
                                int threads, const Progress& progress)
{
    std::vector<Anchor> result(starts.size());
    std::vector<TwoWidths> fits(starts.size());
    Points feet;
    for (const FitStart& start : starts)
        feet.push_back(start.foot);
    const std::vector<Run> runs =
        split_into_runs(feet, longest_run, [&](int i) { return run_radius * starts[i].width; });
    visit_runs(
        runs, threads, progress, [&] { return AnchorFitter(samples, robust_scale); },
        [&](AnchorFitter& fitter, const Run& run)
        {
            fitter.prepare(run.centre, run.radius + largest_in(run, [&](int a) { return fit_cut * starts[a].width; }));
            for (int a = run.begin; a < run.end; ++a)
                result[a] = fitter.fit(starts[a], fits[a]);
        });
    correct_bends(result, fits, starts, threads);
    return result;
}

} // namespace recon
