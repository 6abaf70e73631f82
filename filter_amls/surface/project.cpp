#include "project.h"

#include "anchor_sums.h"
#include "filter_amls/cells/cells_across.h"
#include "filter_amls/fits/runs.h"
#include "residual_field.h"
#include "surface_data.h"

#include <recon/errors.h>
#include <recon/parallel.h>
#include <recon/search/spatial_order.h>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

constexpr double least_weight = 1e-6;                     // below it no anchor is near
constexpr int widenings = 2;                              // times the width is doubled then
constexpr double motion_sigmas = 6, motion_widths = 0.05; // how far noise moves a point at most
constexpr double foreign_motion = 1.5; // distances from the cloud, of a point that was not among the samples
constexpr double domain = 0.9; // local feature sizes from which Newton's method on I returns (figure 11, measured)
constexpr double unresolved = 1, unresolved_in_mesh = 0.5;   // spacings: samples do not tell closer detail
constexpr int asked_neighbours = 6, agreeing_neighbours = 2; // that tell an edge from an outlier
constexpr double agreeing_motion = 0.1, agreeing_noise = 2.5,
                 neighbour_distance = 4;                      // share of the motion; sigmas; spacings
constexpr double agreeing_sigmas = 2, agreeing_widths = 0.25; // anchors off by more lose weight
/// Times 1 - cosine of the turn: how much stricter agreement is with anchors that face elsewhere.
constexpr double turning = 3;
/// Times the product of the depths [agreeing distances]: how much less anchors beyond a crease weigh at first.
constexpr double beyond_crease = 100;
constexpr double least_step = 1e-5; // widths: floats resolve 1e-7
constexpr double run_radius = 0.65; // widths
constexpr int longest_run = 64;

/// Projects the points of a run.
class Projector
{
public:
    /// \param sides of the cells: in which half space points look for the surface.
    Projector(const AmlsSurface::Data& data, const Vectors& sides, const AmlsProjectionOptions& options)
        : data_(data), options_(options), sides_(sides)
    {
    }

    /// Makes the anchors around a ball of points ready.
    void prepare(const Point& centre, double radius, double width)
    {
        around_run_.gather(data_, centre, radius, width, options_.cut_off);
    }

    void project(const Point& start, int cell, AmlsProjection& result, std::size_t i)
    {
        const LocalScale& scale = data_.cells.scales[cell];
        const double h = scale.width;
        const Vector side = sides_[cell];
        result.widths[i] = data_.frame.scale() * h;
        result.spacings[i] = data_.frame.scale() / std::sqrt(scale.density);
        result.normals[i] = side;
        result.points[i] = start;
        if (data_.cell_normals.kinds[cell] == CellKind::outlier)
        {
            result.status[i] = options_.foreign_points ? ProjectionStatus::too_far : ProjectionStatus::outlier;
            return;
        }

        const Landing landing = land(start, cell);
        result.iterations[i] = std::uint8_t(std::min(landing.steps, 255));
        result.neighbours[i] = landing.neighbours;
        const double noise_moves = motion_sigmas * scale.sigma + motion_widths * h;
        const double farthest = options_.foreign_points
                                    ? std::max(noise_moves, foreign_motion * (start - data_.cells.means[cell]).norm())
                                    : noise_moves;
        if (landing.found && (landing.x - start).norm() <= farthest)
        {
            result.points[i] = landing.x;
            result.status[i] = landing.converged ? ProjectionStatus::converged : ProjectionStatus::not_converged;
            const double norm = landing.normal.norm();
            if (norm > 0 && std::isfinite(norm))
                result.normals[i] = landing.normal / norm;
            return;
        }
        const Vector to_plane = side * side.dot(data_.cell_normals.feet[cell] - start);
        if (to_plane.norm() <= noise_moves && (!options_.foreign_points || has_anchor(start + to_plane, h)))
        {
            result.points[i] = start + to_plane;
            result.status[i] = ProjectionStatus::fell_back;
        }
        else if (options_.foreign_points)
            result.status[i] = ProjectionStatus::too_far;
        else
            result.status[i] = is_detail(start, landing.found ? Vector(landing.x - start) : to_plane, scale)
                                   ? ProjectionStatus::kept
                                   : ProjectionStatus::outlier;
    }

private:
    /// Where Newton's method leads.
    struct Landing
    {
        Point x;
        Vector normal; ///< Not of unit length.
        int steps = 0;
        std::uint16_t neighbours = 0;
        bool found = false, converged = false;
    };

    Landing land(const Point& start, int cell)
    {
        const LocalScale& scale = data_.cells.scales[cell];
        const double h = scale.width;
        const Vector side = sides_[cell];
        const double enough = std::max(options_.tolerance / std::sqrt(scale.density), least_step * h);
        Landing result;
        result.x = start;
        Point& x = result.x;
        Vector gradient = side;
        result.normal = side;
        double width = h;
        int widened = 0;
        // Once x lies about where most anchors agree, those that do not lose weight; not before, or a point in the tail
        // of the noise would agree with the wrong ones. Before, those beyond a crease do, by the side of its cell: a
        // point on one face would follow the other's plane out of the solid. The normal told does not listen to turns:
        // at a tip few anchors could outvote the side.
        bool settled = false;
        const double agreeing = std::max(agreeing_sigmas * scale.sigma, agreeing_widths * h);
        const GatheredAnchors* anchors = &around_run_;
        const Eigen::Vector3f facing = side.cast<float>();
        while (result.steps < options_.max_iterations)
        {
            if (!anchors->suffice(x, width))
            {
                around_point_.gather(data_, x, 0, width, options_.cut_off);
                anchors = &around_point_;
            }
            const Eigen::Vector3f local = (x - anchors->centre()).cast<float>();
            Agreement agreement;
            if (settled)
            {
                agreement.inverse_distance = float(1 / agreeing);
                agreement.turning = options_.sharp ? float(turning) : 0;
                Eigen::Vector3f::Map(agreement.normal) = gradient.normalized().cast<float>();
            }
            else
            {
                agreement.crease = float(beyond_crease / (agreeing * agreeing));
                const Vector& followed = data_.cell_sides[cell];
                Eigen::Vector3f::Map(agreement.normal) = followed.dot(side) > 0 ? followed.cast<float>() : facing;
            }
            AnchorSums sums;
            sum_anchors(anchors->values(), anchors->stride(), local.data(), facing.data(), float(1 / width),
                        float(options_.cut_off), agreement, &sums);
            if (!(sums.weight >= least_weight))
            {
                if (widened > widenings)
                    break;
                // Wider at first; a point that is farther still starts from the plane of its cell.
                if (++widened <= widenings)
                    width *= 2;
                else if (options_.foreign_points && !is_in_domain(start, cell))
                    break;
                else
                {
                    x += side * side.dot(data_.cell_normals.feet[cell] - x);
                    width = h;
                }
                continue;
            }
            const Vector g = Vector(sums.gradient[0], sums.gradient[1], sums.gradient[2]) / sums.weight;
            Vector step = -(sums.distance / sums.weight) / std::max(0.25, g.squaredNorm()) * g;
            const double length = step.norm();
            if (length > h)
                step *= h / length;
            x += step;
            gradient = g;
            result.normal = Vector::Map(sums.smooth_gradient);
            ++result.steps;
            result.neighbours = std::uint16_t(std::min(sums.count, 65535.0));
            if (length <= enough && (settled || options_.max_iterations == 1))
            {
                result.converged = true;
                break;
            }
            settled = length <= 0.5 * agreeing;
        }
        result.found =
            result.steps > 0 && x.allFinite() && (!options_.foreign_points || widened == 0 || has_anchor(x, h));
        return result;
    }

    /// Whether the surface at a place rests on anchors, and is not extrapolated.
    bool has_anchor(const Point& p, double width) const
    {
        const double reach = GatheredAnchors::narrowing * options_.cut_off * width;
        return (data_.anchor_positions[std::size_t(data_.anchor_search.nearest(p))] - p).squaredNorm() <= reach * reach;
    }

    /// Whether a point lies nearer to its cell than the medial axis, beyond which other places are as near.
    bool is_in_domain(const Point& p, int cell) const
    {
        const int pole = data_.pole_search.nearest(data_.cell_normals.feet[cell]);
        if (pole < 0)
            return true;
        const double size = (data_.poles[std::size_t(pole)] - data_.cell_normals.feet[cell]).norm();
        return (p - data_.cells.means[cell]).norm() <= domain * size;
    }

    /// Whether a sample that lies farther from the surface than noise explains is detail, as of a sharp edge, which the
    /// surface rounds: nearer than samples tell, or samples around it lie off likewise. An outlier has its place alone.
    bool is_detail(const Point& sample, const Vector& motion, const LocalScale& scale)
    {
        const double squared_motion = motion.squaredNorm();
        const double close = options_.sharp ? unresolved : unresolved_in_mesh;
        if (squared_motion * scale.density < close * close)
            return true;
        int near[asked_neighbours + 1];
        double squared[asked_neighbours + 1];
        const int count = data_.point_search.nearest(sample, asked_neighbours + 1, near, squared);
        int agreeing = 0;
        for (int k = 0; k < count; ++k)
        {
            const int cell = data_.cells.cell_of_point[std::size_t(near[k])];
            if (squared[k] == 0 || squared[k] * scale.density > neighbour_distance * neighbour_distance ||
                data_.cell_normals.kinds[cell] == CellKind::outlier)
                continue;
            const Point& other = data_.points[std::size_t(near[k])];
            const Landing landing = land(other, cell);
            agreeing += landing.found &&
                        (landing.x - other).dot(motion) >
                            std::sqrt(squared_motion) *
                                std::max(agreeing_motion * std::sqrt(squared_motion), agreeing_noise * scale.sigma);
        }
        return agreeing >= agreeing_neighbours;
    }

    const AmlsSurface::Data& data_;
    const AmlsProjectionOptions& options_;
    const Vectors& sides_;
    GatheredAnchors around_run_, around_point_;
};

/// Whether the surface's points have been projected with these options.
bool are_at_hand(const AmlsSurface::Data& data, const AmlsProjectionOptions& options)
{
    const AmlsProjectionOptions defaults;
    return !data.projected.points.empty() && options.max_iterations == defaults.max_iterations &&
           options.tolerance == defaults.tolerance && options.cut_off == defaults.cut_off &&
           options.foreign_points == defaults.foreign_points && options.sharp == data.sharp;
}

void resize(AmlsProjection& p, std::size_t size)
{
    p.points.resize(size);
    p.normals.resize(size);
    p.status.resize(size);
    p.widths.resize(size);
    p.spacings.resize(size);
    p.iterations.resize(size);
    p.neighbours.resize(size);
}

} // namespace

AmlsProjection project_in_frame(const AmlsSurface::Data& data, const Points& unit, const std::vector<int>& cell,
                                const AmlsProjectionOptions& options, int threads, const Progress& progress)
{
    Vectors plain_sides;
    if (!options.sharp)
        plain_sides =
            turn_cells_across(data.points, data.point_search, data.cells, data.cell_search, data.cell_normals, threads);
    const Vectors& sides = options.sharp ? data.cell_sides : plain_sides;
    AmlsProjection sorted;
    resize(sorted, unit.size());
    const std::vector<Run> runs =
        split_into_runs(unit, longest_run, [&](int i) { return run_radius * data.cells.scales[cell[i]].width; });
    visit_runs(
        runs, threads, progress, [&] { return Projector(data, sides, options); },
        [&](Projector& projector, const Run& run)
        {
            const double width = largest_in(run, [&](int i) { return data.cells.scales[cell[i]].width; });
            projector.prepare(run.centre, run.radius, width);
            for (int i = run.begin; i < run.end; ++i)
                projector.project(unit[i], cell[i], sorted, std::size_t(i));
        });
    return sorted;
}

namespace
{

/// The cells among which that of a point is sought. Outliers among the samples have none to give to points that are not
/// of the samples.
class SearchedCells
{
public:
    SearchedCells(const AmlsSurface::Data& data, bool without_outliers, int threads) : search_(&data.cell_search)
    {
        const auto is_sound = [&](CellKind kind) { return kind != CellKind::outlier; };
        const std::vector<CellKind>& kinds = data.cell_normals.kinds;
        if (!without_outliers || std::all_of(kinds.begin(), kinds.end(), is_sound) ||
            std::none_of(kinds.begin(), kinds.end(), is_sound))
            return;
        Points means;
        for (int c = 0; c < data.cells.size(); ++c)
            if (is_sound(kinds[c]))
            {
                cells_.push_back(c);
                means.push_back(data.cells.means[c]);
            }
        sound_ = BlockSearch(means, threads);
        search_ = &sound_;
    }
    SearchedCells(const SearchedCells&) = delete;

    /// \param reach a guess that the search improves, 0 at first.
    int nearest(const Point& p, double& reach) const
    {
        int found = 0;
        double squared = 0;
        search_->nearest(p, 1, &found, &squared, reach);
        return cells_.empty() ? found : cells_[found];
    }

private:
    std::vector<int> cells_; ///< Of `sound_`; empty: all.
    BlockSearch sound_;
    const BlockSearch* search_;
};

} // namespace

AmlsProjection project_to_amls(const Points& points, const AmlsSurface& surface, const AmlsProjectionOptions& options,
                               const Progress& progress)
{
    const ThreadTeam team;
    if (options.max_iterations < 1)
        throw InvalidInput("The number of iterations must be at least 1.");
    if (!(options.tolerance > 0) || !std::isfinite(options.tolerance))
        throw InvalidInput("The tolerance must be a positive number.");
    if (!(options.cut_off > 0) || options.cut_off * options.cut_off > 8)
        throw InvalidInput("The cut-off must lie between 0 and 2.8 widths.");
    const int threads = resolve_threads(options.threads);
    for (std::size_t i = 0; i < points.size(); ++i)
        check_finite(points[i], i);
    const AmlsSurface::Data& data = surface.data();
    const std::size_t n = points.size();

    // Sorted, so that one query for anchors serves many points; equal points are computed once.
    const bool own = data.was_made_of(points);
    const SpatialOrder other = own ? SpatialOrder{} : order_spatially(points, threads);
    const SpatialOrder& spatial = own ? data.spatial : other;
    const std::size_t m = spatial.order.size();
    Points moved;
    std::vector<int> nearest_cell;
    if (!own)
    {
        moved.resize(m);
        nearest_cell.resize(m);
        const SearchedCells searched(data, options.foreign_points, threads);
        parallel_chunks(m, threads, 4096, progress.part(0, 0.2, "Projection"),
                        [&](std::size_t begin, std::size_t end)
                        {
                            double reach = 0;
                            for (std::size_t i = begin; i < end; ++i)
                            {
                                moved[i] = data.frame.to_unit(points[spatial.order[i]]);
                                nearest_cell[i] = searched.nearest(moved[i], reach);
                            }
                        });
    }
    const Points& unit = own ? data.points : moved;
    const std::vector<int>& cell = own ? data.cells.cell_of_point : nearest_cell;
    progress.report(0);
    AmlsProjection projected;
    const bool at_hand = own && are_at_hand(data, options);
    if (!at_hand)
    {
        projected = project_in_frame(data, unit, cell, options, threads, progress.part(0.2, 0.9, "Projection"));
        const Progress corrections = progress.part(0.9, 1, "Projection");
        const double passes = double(data.residuals.size());
        for (std::size_t k = 0; k < data.residuals.size(); ++k)
            correct_by_residuals(data, data.residuals[k], cell, projected, threads,
                                 corrections.part(double(k) / passes, double(k + 1) / passes, "Projection"));
    }
    const AmlsProjection& sorted = at_hand ? data.projected : projected;

    AmlsProjection result;
    resize(result, n);
    parallel_for(
        n, threads, {},
        [&](std::size_t i)
        {
            const std::size_t s = std::size_t(spatial.representative[i]);
            result.points[i] = is_moved(sorted.status[s]) ? data.frame.from_unit(sorted.points[s]) : points[i];
            result.normals[i] = sorted.normals[s];
            result.status[i] = sorted.status[s];
            result.widths[i] = sorted.widths[s];
            result.spacings[i] = sorted.spacings[s];
            result.iterations[i] = sorted.iterations[s];
            result.neighbours[i] = sorted.neighbours[s];
        },
        4096);
    return result;
}

} // namespace recon
