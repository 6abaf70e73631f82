#include "fit.h"

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

constexpr double fit_cut = 2.6;      // widths
constexpr double robust_sigmas = 1.2;  // residuals beyond it lose weight in the second fit
constexpr double largest_turn = 0.5; // cosine
constexpr double largest_move = 0.4; // widths
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

/// Anchor of one cell; `gathered` holds the cells around, relative to `origin`.
Anchor fit_anchor(const Gathered& gathered, const Point& origin, const Point& foot, const Vector& normal,
                  const LocalScale& scale, double width)
{
    Anchor anchor{foot, normal, {}, 0, width};
    QuadricWeights how{width, fit_cut};
    how.same_side_only = true;
    how.robust_scale = robust_sigmas * scale.sigma;

    Point position = foot - origin;
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
    const double moved = (position + origin - foot).norm();
    if (!position.allFinite() || !direction.allFinite() || direction.dot(normal) < largest_turn ||
        moved > std::max(largest_move * width, largest_move_sigmas * scale.sigma))
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

} // namespace

std::vector<Anchor> fit_anchors(const Cells& cells, const BlockSearch& search, const Vectors& normals,
                                const Points& feet, const std::vector<int>& anchors, const std::vector<double>& widths,
                                int threads, const Progress& progress)
{
    std::vector<Anchor> result(anchors.size());
    Points positions;
    for (int c : anchors)
        positions.push_back(feet[c]);
    const std::vector<Run> runs =
        split_into_runs(positions, longest_run, [&](int i) { return run_radius * widths[i]; });
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
                                reach = std::max(reach, (fit_cut + 0.2) * widths[a]);
                            search.within(run.centre, run.radius + reach, found);
                            gathered.gather(cells.means, cells.counts, found, run.centre);
                            gathered.gather_directions(normals, found);
                            for (int a = run.begin; a < run.end; ++a)
                                result[a] = fit_anchor(gathered, run.centre, positions[a], normals[anchors[a]],
                                                       cells.scales[anchors[a]], widths[a]);
                        }
                    });
    return result;
}

} // namespace recon
