#include "project.h"

#include "residual_field.h"
#include "runs.h"
#include "surface_data.h"

#include <recon/errors.h>
#include <recon/parallel.h>
#include <recon/simd.h>
#include <recon/spatial_order.h>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

using Lanes = simd::FloatLanes;

constexpr double narrowing = 0.85;                        // of the widths: quadrics need less averaging than planes
constexpr double least_weight = 1e-6;                     // below it no anchor is near
constexpr int widenings = 2;                              // times the width is doubled then
constexpr double motion_sigmas = 6, motion_widths = 0.05; // how far noise moves a point at most
constexpr double foreign_motion = 1.5; // distances from the cloud, of a point that was not among the samples
constexpr double domain = 0.9; // local feature sizes from which Newton's method on I returns (figure 11, measured)
constexpr double unresolved = 1, unresolved_in_mesh = 0.5;   // spacings: samples do not tell closer detail
constexpr int asked_neighbours = 6, agreeing_neighbours = 2; // that tell an edge from an outlier
constexpr double agreeing_motion = 0.1, agreeing_noise = 2.5,
                 neighbour_distance = 4; // share of the motion; sigmas; spacings
constexpr double slack = 0.35;           // widths: how far a point may move before its anchors are gathered again
constexpr double agreeing_sigmas = 2, agreeing_widths = 0.25; // anchors off by more lose weight
/// Times 1 - cosine of the turn: how much stricter agreement is with anchors that face elsewhere.
constexpr double turning = 3;
constexpr double least_step = 1e-5; // widths: floats resolve 1e-7
constexpr double uneven = 1.25;     // root of the ratio of neighbouring widths
constexpr double run_radius = 0.65; // widths
constexpr int longest_run = 64;

/// Anchors near a ball of points, side by side for the vector units.
class GatheredAnchors
{
public:
    enum Field
    {
        x,
        y,
        z,
        nx,
        ny,
        nz,
        qxx,
        qyy,
        qzz,
        qxy,
        qxz,
        qyz,
        confidence,
        inverse_width,
        field_count
    };

    /// Those that count at points of up to `width` within `radius` of `centre`, and somewhat farther.
    void gather(const AmlsSurface::Data& data, const Point& centre, double radius, double width, double cut_off)
    {
        centre_ = centre;
        width_ = width * (1 + 1e-12);
        radius_ = radius + slack * width;
        const double reach = narrowing * cut_off;
        data.anchor_search.within(centre, radius_ + reach * uneven * width, found_);
        const auto is_beyond = [&](int i)
        {
            const Anchor& a = data.anchors[i];
            const double farthest = radius_ + reach * std::sqrt(width_ * a.width);
            return (a.position - centre).squaredNorm() > farthest * farthest;
        };
        found_.erase(std::remove_if(found_.begin(), found_.end(), is_beyond), found_.end());
        stride_ = std::size_t(simd::padded(int(found_.size())));
        values_.assign(stride_ * field_count, 0);
        for (std::size_t i = 0; i < found_.size(); ++i)
        {
            const Anchor& a = data.anchors[found_[i]];
            float* value = &values_[i];
            for (int k = 0; k < 3; ++k)
            {
                value[(x + k) * stride_] = float(a.position[k] - centre[k]);
                value[(nx + k) * stride_] = float(a.normal[k]);
            }
            for (int k = 0; k < 6; ++k)
                value[(qxx + k) * stride_] = float(a.bending[k]);
            value[confidence * stride_] = float(a.confidence);
            value[inverse_width * stride_] = float(1 / (narrowing * narrowing * a.width));
        }
    }

    /// Whether they suffice for a point.
    bool suffice(const Point& p, double width) const { return width <= width_ && (p - centre_).norm() <= radius_; }

    const float* values() const { return values_.data(); }
    std::size_t stride() const { return stride_; }
    const Point& centre() const { return centre_; } ///< Origin of their positions.

private:
    std::vector<int> found_;
    std::vector<float> values_;
    std::size_t stride_ = 0;
    Point centre_ = Point::Zero();
    double radius_ = 0, width_ = 0;
};

/// Which anchors agree with a point: those that pass it nearby, the nearer the less they face as the surface does
/// there.
struct Agreement
{
    float inverse_distance = 0; ///< 0: all do.
    float normal[3] = {0, 0, 0};
    float turning = 0;
};

/// W, sum theta d, sum theta grad d, and the number of anchors that count; smooth_gradient: wherever they face.
struct Sums
{
    double weight, distance, gradient[3], smooth_gradient[3], count;
};

RECON_VECTOR_CLONES
void sum_anchors(const float* values, std::size_t stride, const float* p, const float* side, float inverse_width,
                 float cut, const Agreement& agreement, Sums* sums)
{
    using G = GatheredAnchors;
    Lanes weight = {}, distance = {}, gx = {}, gy = {}, gz = {}, sx = {}, sy = {}, sz = {}, count = {};
    const float* face = agreement.normal;
    const float limit = cut * cut;
    const Lanes zero = {}, one = zero + 1.0f, most = zero + 8.0f;
    for (std::size_t i = 0; i < stride; i += simd::lane_count)
    {
        const float* v = values + i;
        const Lanes ux = p[0] - simd::load(v + G::x * stride), uy = p[1] - simd::load(v + G::y * stride),
                    uz = p[2] - simd::load(v + G::z * stride);
        const Lanes nx = simd::load(v + G::nx * stride), ny = simd::load(v + G::ny * stride),
                    nz = simd::load(v + G::nz * stride);
        const Lanes e = (ux * ux + uy * uy + uz * uz) * (simd::load(v + G::inverse_width * stride) * inverse_width);
        const Lanes facing = nx * side[0] + ny * side[1] + nz * side[2];
        Lanes w = simd::load(v + G::confidence * stride) * simd::exp_negative(e < most ? e : most);
        w = e <= limit ? w : zero;
        w = facing > zero ? w : zero;
        const Lanes qxy = simd::load(v + G::qxy * stride), qxz = simd::load(v + G::qxz * stride),
                    qyz = simd::load(v + G::qyz * stride);
        const Lanes qx = simd::load(v + G::qxx * stride) * ux + qxy * uy + qxz * uz,
                    qy = qxy * ux + simd::load(v + G::qyy * stride) * uy + qyz * uz,
                    qz = qxz * ux + qyz * uy + simd::load(v + G::qzz * stride) * uz;
        const Lanes d = ux * (nx - qx) + uy * (ny - qy) + uz * (nz - qz);
        const Lanes off = d * agreement.inverse_distance;
        const Lanes turn = (one - (nx * face[0] + ny * face[1] + nz * face[2])) * agreement.turning;
        const Lanes near = 1.0f / (1.0f + off * off), alike = 1.0f / (1.0f + off * off * (one + turn));
        const Lanes smooth = w * near * near;
        w *= alike * alike;
        const Lanes dx = nx - 2.0f * qx, dy = ny - 2.0f * qy, dz = nz - 2.0f * qz;
        weight += w;
        distance += w * d;
        gx += w * dx;
        gy += w * dy;
        gz += w * dz;
        sx += smooth * dx;
        sy += smooth * dy;
        sz += smooth * dz;
        count += w > zero ? one : zero;
    }
    sums->weight = simd::sum(weight);
    sums->distance = simd::sum(distance);
    sums->gradient[0] = simd::sum(gx);
    sums->gradient[1] = simd::sum(gy);
    sums->gradient[2] = simd::sum(gz);
    sums->smooth_gradient[0] = simd::sum(sx);
    sums->smooth_gradient[1] = simd::sum(sy);
    sums->smooth_gradient[2] = simd::sum(sz);
    sums->count = simd::sum(count);
}

/// Projects the points of a run.
class Projector
{
public:
    Projector(const AmlsSurface::Data& data, const AmlsProjectionOptions& options)
        : data_(data), options_(options), sides_(options.sharp ? data.cell_sides : data.cell_normals.normals)
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
        // Once x lies about where most anchors agree, those that do not, as beyond a crease, lose weight; not before,
        // or a point in the tail of the noise would agree with the wrong ones. The normal told does not listen to
        // turns: at a tip few anchors could outvote the side.
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
            Sums sums;
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
        const double reach = narrowing * options_.cut_off * width;
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

/// Whether the result is that of the options' defaults.
bool are_defaults(const AmlsProjectionOptions& options)
{
    const AmlsProjectionOptions defaults;
    return options.max_iterations == defaults.max_iterations && options.tolerance == defaults.tolerance &&
           options.cut_off == defaults.cut_off && options.foreign_points == defaults.foreign_points &&
           options.sharp == defaults.sharp;
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

int AmlsProjection::count(ProjectionStatus wanted) const
{
    return int(std::count(status.begin(), status.end(), wanted));
}

AmlsProjection project_in_frame(const AmlsSurface::Data& data, const Points& unit, const std::vector<int>& cell,
                                const AmlsProjectionOptions& options, int threads, const Progress& progress)
{
    AmlsProjection sorted;
    resize(sorted, unit.size());
    const std::vector<Run> runs =
        split_into_runs(unit, longest_run, [&](int i) { return run_radius * data.cells.scales[cell[i]].width; });
    visit_runs(
        runs, threads, progress, [&] { return Projector(data, options); },
        [&](Projector& projector, const Run& run)
        {
            const double width = largest_in(run, [&](int i) { return data.cells.scales[cell[i]].width; });
            projector.prepare(run.centre, run.radius, width);
            for (int i = run.begin; i < run.end; ++i)
                projector.project(unit[i], cell[i], sorted, std::size_t(i));
        });
    return sorted;
}

AmlsProjection project_to_amls(const Points& points, const AmlsSurface& surface, const AmlsProjectionOptions& options,
                               const Progress& progress)
{
    if (options.max_iterations < 1)
        throw InvalidInput("The number of iterations must be at least 1.");
    if (!(options.tolerance > 0) || !std::isfinite(options.tolerance))
        throw InvalidInput("The tolerance must be a positive number.");
    if (!(options.cut_off > 0) || options.cut_off * options.cut_off > 8)
        throw InvalidInput("The cut-off must lie between 0 and 2.8 widths.");
    const int threads = resolve_threads(options.threads);
    for (std::size_t i = 0; i < points.size(); ++i)
        if (!points[i].allFinite())
            throw InvalidInput("Vertex " + std::to_string(i) +
                               " has a coordinate that is not a finite number. Delete such vertices first.");
    const AmlsSurface::Data& data = surface.data();
    const std::size_t n = points.size();

    // Sorted, so that one query for anchors serves many points; equal points are computed once.
    const bool own = data.was_made_of(points);
    const SpatialOrder other = own ? SpatialOrder{} : order_spatially(points);
    const SpatialOrder& spatial = own ? data.spatial : other;
    const std::size_t m = spatial.order.size();
    Points moved;
    std::vector<int> nearest_cell;
    if (!own)
    {
        moved.resize(m);
        nearest_cell.resize(m);
        parallel_chunks(m, threads, 4096, progress.part(0, 0.2, "Projection"),
                        [&](std::size_t begin, std::size_t end)
                        {
                            double squared = 0, reach = 0;
                            for (std::size_t i = begin; i < end; ++i)
                            {
                                moved[i] = data.frame.to_unit(points[spatial.order[i]]);
                                data.cell_search.nearest(moved[i], 1, &nearest_cell[i], &squared, reach);
                            }
                        });
    }
    const Points& unit = own ? data.points : moved;
    const std::vector<int>& cell = own ? data.cells.cell_of_point : nearest_cell;
    progress.report(0);
    AmlsProjection projected;
    const bool at_hand = own && !data.projected.points.empty() && are_defaults(options);
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
