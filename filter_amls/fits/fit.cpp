#include "fit.h"

#include "bend_correction.h"
#include "runs.h"
#include "stretched_frame.h"
#include "weighted_sums.h"

#include <recon/parallel.h>
#include <recon/search/block_search.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace recon
{
namespace
{

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
constexpr double round_suffices = 1.25; // of a stretch: up to it the samples of the round window hold what counts
constexpr double later_stretch = 1.2;   // of lengths: by how much later rounds may stretch otherwise

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

/// Fits the anchors of a run; holds the samples last gathered.
class AnchorFitter
{
public:
    AnchorFitter(const FitSamples& samples, const std::vector<FitStart>& starts, double robust_scale)
        : samples_(samples), starts_(starts), robust_scale_(robust_scale)
    {
    }

    /// Anchors in plain places at once; those with longer windows after them, since these ask for more samples.
    void fit(const Run& run, std::vector<Anchor>& anchors, std::vector<TwoWidths>& fits)
    {
        const double reach = fit_cut * largest_in(run, [&](int a) { return starts_[a].width; });
        gather(run.centre, run.radius + reach);
        stretched_.clear();
        double longest = 1;
        for (int a = run.begin; a < run.end; ++a)
        {
            const FitStart& start = starts_[a];
            const Beginning beginning = begin(start);
            const double stretch = stretch_of(beginning.next);
            if (stretch > round_suffices)
            {
                stretched_.push_back({a, beginning});
                longest = std::max(longest, stretch);
            }
            else
                anchors[a] = finish(start, beginning, fits[a]);
        }
        if (stretched_.empty())
            return;
        gather(run.centre, run.radius + later_stretch * longest * reach);
        for (const auto& [a, beginning] : stretched_)
        {
            const FitStart& start = starts_[a];
            around_.gather_facing(around_run_, beginning.position + beginning.fit.c[0] * start.normal, beginning.next,
                                  later_stretch * fit_cut * start.width, start.normal, facing_cosine);
            anchors[a] = finish(start, beginning, fits[a]);
        }
    }

private:
    /// Fit over a round window, from which the others go on.
    struct Beginning
    {
        Point position; ///< From the centre of the run.
        TangentFrame frame;
        QuadricFit fit;
        TangentFrame next; ///< Of the next fit; unused if this one is not valid.
    };

    void gather(const Point& centre, double radius)
    {
        samples_.search.within(centre, radius, found_);
        around_run_.gather(samples_.points, samples_.weights, found_, centre);
        around_run_.gather_directions(samples_.normals, found_);
        origin_ = centre;
    }

    Beginning begin(const FitStart& start)
    {
        const TangentFrame frame(start.normal);
        const Point position = start.foot - origin_;
        around_.gather_facing(around_run_, position, frame, fit_cut * start.width, start.normal, facing_cosine);
        const QuadricFit fit = fit_quadric(around_, position, frame, {start.width, fit_cut});
        return {position, frame, fit, fit.valid ? next_frame(fit, frame, start) : frame};
    }

    static TangentFrame next_frame(const QuadricFit& fit, const TangentFrame& frame, const FitStart& start)
    {
        return stretch_along_bend(fit, frame, normal_of(fit, frame, start.width), start.width, start.sigma);
    }

    /// With the samples gathered last.
    Anchor finish(const FitStart& start, const Beginning& beginning, TwoWidths& two)
    {
        const double width = start.width;
        auto [position, frame, fit, next] = beginning;
        Anchor anchor{start.foot, start.normal, {}, 0, width};
        const double plane_confidence = std::min(fit.effective, enough_points);
        if (!fit.valid)
        {
            anchor.confidence = std::min(fit.effective, 1.0);
            return anchor;
        }
        QuadricWeights how{width, fit_cut};
        how.robust_scale = robust_scale_ * start.sigma;
        const int rounds = robust_scale_ < picky_scale ? many_rounds : few_rounds;
        for (int round = 1;; ++round)
        {
            position += fit.c[0] * frame.normal;
            // The surface seen from the frame moved and turned to it: neither offset nor slope are left.
            const QuadricFit moved = with_bending_in(next, fit, frame);
            frame = next;
            how.robust_about = &moved;
            const QuadricFit again = fit_quadric(around_, position, frame, how);
            if (!again.valid)
            {
                fit = moved;
                break;
            }
            fit = again;
            if (round + 1 < rounds)
            {
                next = next_frame(fit, frame, start);
                continue;
            }
            two.narrow = fit_narrower(around_, position, frame, how, moved);
            two.wide = fit;
            two.comparable = two.narrow.valid && two.narrow.effective > least_points;
            break;
        }
        two.position = position + origin_;
        two.frame = frame;
        place_anchor(anchor, two.position, frame, fit, width);
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

    const FitSamples& samples_;
    const std::vector<FitStart>& starts_;
    double robust_scale_;
    std::vector<int> found_;
    Gathered around_run_, around_;
    std::vector<std::pair<int, Beginning>> stretched_;
    Point origin_ = Point::Zero();
};

} // namespace

void place_anchor(Anchor& anchor, const Point& position, const TangentFrame& frame, const QuadricFit& fit, double width)
{
    anchor.position = position + fit.c[0] * frame.normal;
    anchor.normal = normal_of(fit, frame, width);
    const Eigen::Matrix3d q = bending_of(fit, frame, width);
    anchor.bending = {q(0, 0), q(1, 1), q(2, 2), q(0, 1), q(0, 2), q(1, 2)};
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
        runs, threads, progress, [&] { return AnchorFitter(samples, starts, robust_scale); },
        [&](AnchorFitter& fitter, const Run& run) { fitter.fit(run, result, fits); });
    correct_bends(result, fits, starts, threads);
    return result;
}

} // namespace recon
