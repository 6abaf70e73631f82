#include "project.h"

#include "runs.h"
#include "simd.h"
#include "surface_data.h"

#include <recon/errors.h>
#include <recon/parallel.h>
#include <recon/spatial_order.h>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

using simd::Lanes;

constexpr double narrowing = 0.85;                        // of the widths: quadrics need less averaging than planes
constexpr double least_weight = 1e-6;                     // below it no anchor is near
constexpr int widenings = 2;                              // times the width is doubled then
constexpr double motion_sigmas = 6, motion_widths = 0.05; // how far noise moves a point at most
constexpr double foreign_motion = 1.5; // distances from the cloud, of a point that was not among the samples
constexpr double slack = 0.35;         // widths: how far a point may move before its anchors are gathered again
constexpr double agreeing_sigmas = 2, agreeing_widths = 0.25; // anchors off by more lose weight
constexpr double uneven = 1.25;                               // root of the ratio of neighbouring widths
constexpr double run_radius = 0.65;                           // widths
constexpr int longest_run = 64;

/// Anchors near a run of points, side by side for the vector units.
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

    void gather(const std::vector<Anchor>& anchors, const std::vector<int>& indices, const Point& origin)
    {
        size_ = int(indices.size());
        stride_ = std::size_t(simd::padded(size_));
        values_.resize(stride_ * field_count);
        for (std::size_t i = 0; i < stride_; ++i)
        {
            double* value = &values_[i];
            if (int(i) >= size_)
            {
                for (int f = 0; f < field_count; ++f)
                    value[f * stride_] = 0;
                continue;
            }
            const Anchor& a = anchors[indices[i]];
            for (int k = 0; k < 3; ++k)
            {
                value[(x + k) * stride_] = a.position[k] - origin[k];
                value[(nx + k) * stride_] = a.normal[k];
            }
            for (int k = 0; k < 6; ++k)
                value[(qxx + k) * stride_] = a.bending[k];
            value[confidence * stride_] = a.confidence;
            value[inverse_width * stride_] = 1 / (narrowing * narrowing * a.width);
        }
    }
    const double* values() const { return values_.data(); }
    std::size_t stride() const { return stride_; }

private:
    std::vector<double> values_;
    std::size_t stride_ = 0;
    int size_ = 0;
};

/// W, sum theta d, sum theta grad d, and the number of anchors that count.
struct Sums
{
    double weight, distance, gradient[3], count;
};

RECON_VECTOR_CLONES
void sum_anchors(const double* values, std::size_t stride, const double* p, const double* side, double inverse_width,
                 double cut, double inverse_agreeing, Sums* sums)
{
    using G = GatheredAnchors;
    Lanes weight = {}, distance = {}, gx = {}, gy = {}, gz = {}, count = {};
    const double limit = cut * cut;
    const Lanes one = simd::zero() + 1.0;
    for (std::size_t i = 0; i < stride; i += simd::lane_count)
    {
        const double* v = values + i;
        const Lanes ux = p[0] - simd::load(v + G::x * stride), uy = p[1] - simd::load(v + G::y * stride),
                    uz = p[2] - simd::load(v + G::z * stride);
        const Lanes nx = simd::load(v + G::nx * stride), ny = simd::load(v + G::ny * stride),
                    nz = simd::load(v + G::nz * stride);
        const Lanes e = (ux * ux + uy * uy + uz * uz) * (simd::load(v + G::inverse_width * stride) * inverse_width);
        const Lanes facing = nx * side[0] + ny * side[1] + nz * side[2];
        Lanes w = simd::load(v + G::confidence * stride) * simd::exp_negative(simd::smaller(e, one * 8.0));
        w = e <= limit ? w : simd::zero();
        w = facing > simd::zero() ? w : simd::zero();
        const Lanes qxy = simd::load(v + G::qxy * stride), qxz = simd::load(v + G::qxz * stride),
                    qyz = simd::load(v + G::qyz * stride);
        const Lanes qx = simd::load(v + G::qxx * stride) * ux + qxy * uy + qxz * uz,
                    qy = qxy * ux + simd::load(v + G::qyy * stride) * uy + qyz * uz,
                    qz = qxz * ux + qyz * uy + simd::load(v + G::qzz * stride) * uz;
        const Lanes d = ux * (nx - qx) + uy * (ny - qy) + uz * (nz - qz);
        const Lanes off = d * inverse_agreeing, damping = 1.0 / (1.0 + off * off);
        w *= damping * damping;
        weight += w;
        distance += w * d;
        gx += w * (nx - 2.0 * qx);
        gy += w * (ny - 2.0 * qy);
        gz += w * (nz - 2.0 * qz);
        count += w > simd::zero() ? one : simd::zero();
    }
    sums->weight = simd::sum(weight);
    sums->distance = simd::sum(distance);
    sums->gradient[0] = simd::sum(gx);
    sums->gradient[1] = simd::sum(gy);
    sums->gradient[2] = simd::sum(gz);
    sums->count = simd::sum(count);
}

/// Projects single points; holds the anchors last gathered.
class Projector
{
public:
    Projector(const AmlsSurface::Data& data, const AmlsProjectionOptions& options) : data_(data), options_(options) {}

    /// Makes the anchors around a ball of points ready.
    void prepare(const Point& centre, double radius, double width)
    {
        fresh_ = true;
        prepared_centre_ = centre;
        prepared_radius_ = radius + slack * width;
        origin_ = centre;
        gather(centre, prepared_radius_ + reach(width));
    }

    /// \returns whether the anchors at hand suffice for a point of that width.
    bool is_prepared(const Point& p, double width, double prepared_width) const
    {
        return width <= prepared_width * (1 + 1e-12) && (p - prepared_centre_).norm() <= prepared_radius_;
    }

    /// False once project() had to gather anchors of its own.
    bool is_fresh() const { return fresh_; }

    void project(const Point& start, int cell, double prepared_width, AmlsProjection& result, std::size_t i)
    {
        const LocalScale& scale = data_.cells.scales[cell];
        const double h = scale.width;
        const Vector side = data_.cell_normals.normals[cell];
        result.widths[i] = data_.frame.scale() * h;
        result.spacings[i] = data_.frame.scale() / std::sqrt(scale.density);
        result.normals[i] = side;
        result.points[i] = start;

        double farthest = motion_sigmas * scale.sigma + motion_widths * h;
        if (options_.foreign_points)
            farthest = std::max(farthest, foreign_motion * (start - data_.cells.means[cell]).norm());
        if (data_.cell_normals.kinds[cell] == CellKind::outlier)
        {
            result.status[i] = ProjectionStatus::outlier;
            return;
        }

        const double enough = options_.tolerance / std::sqrt(scale.density);
        Point x = start;
        Vector gradient = side;
        double width = h;
        int widened = 0, step_count = 0;
        // Once x lies about where most anchors agree, those that do not, as beyond a crease, lose weight; not before,
        // or a point in the tail of the noise would agree with the wrong ones.
        bool settled = false;
        const double agreeing = std::max(agreeing_sigmas * scale.sigma, agreeing_widths * h);
        ProjectionStatus status = ProjectionStatus::not_converged;
        while (step_count < options_.max_iterations)
        {
            if (!is_prepared(x, width, prepared_width))
            {
                prepared_width = width;
                prepare(x, 0, width);
                fresh_ = false;
            }
            const Point local = x - origin_;
            Sums sums;
            sum_anchors(anchors_.values(), anchors_.stride(), local.data(), side.data(), 1 / width, options_.cut_off,
                        settled ? 1 / agreeing : 0, &sums);
            if (!(sums.weight >= least_weight))
            {
                if (widened > widenings)
                    break;
                // Wider at first; a point that is farther still starts from the plane of its cell.
                if (++widened <= widenings)
                    width *= 2;
                else
                    x += side * side.dot(data_.cell_normals.feet[cell] - x);
                continue;
            }
            const Vector g = Vector(sums.gradient[0], sums.gradient[1], sums.gradient[2]) / sums.weight;
            Vector step = -(sums.distance / sums.weight) / std::max(0.25, g.squaredNorm()) * g;
            const double length = step.norm();
            if (length > h)
                step *= h / length;
            x += step;
            gradient = g;
            ++step_count;
            result.neighbours[i] = std::uint16_t(std::min(sums.count, 65535.0));
            if (length <= enough && (settled || options_.max_iterations == 1))
            {
                status = ProjectionStatus::converged;
                break;
            }
            settled = length <= 0.5 * agreeing;
        }
        result.iterations[i] = std::uint8_t(std::min(step_count, 255));

        if (step_count == 0 || !x.allFinite() || (x - start).squaredNorm() > farthest * farthest)
        {
            const Vector to_plane = side * side.dot(data_.cell_normals.feet[cell] - start);
            if (to_plane.norm() > farthest)
            {
                result.status[i] = ProjectionStatus::outlier;
                return;
            }
            result.points[i] = start + to_plane;
            result.status[i] = ProjectionStatus::fell_back;
            return;
        }
        result.points[i] = x;
        result.status[i] = status;
        const double norm = gradient.norm();
        if (norm > 0 && std::isfinite(norm))
            result.normals[i] = gradient / norm;
    }

private:
    double reach(double width) const { return narrowing * options_.cut_off * uneven * width; }

    void gather(const Point& centre, double radius)
    {
        data_.anchor_search.within(centre, radius, found_);
        anchors_.gather(data_.anchors, found_, origin_);
    }

    const AmlsSurface::Data& data_;
    const AmlsProjectionOptions& options_;
    std::vector<int> found_;
    GatheredAnchors anchors_;
    Point origin_ = Point::Zero(), prepared_centre_ = Point::Zero();
    double prepared_radius_ = 0;
    bool fresh_ = false;
};

} // namespace

int AmlsProjection::count(ProjectionStatus wanted) const
{
    return int(std::count(status.begin(), status.end(), wanted));
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
    AmlsProjection sorted;
    const auto resize = [](AmlsProjection& p, std::size_t size)
    {
        p.points.resize(size);
        p.normals.resize(size);
        p.status.resize(size);
        p.widths.resize(size);
        p.spacings.resize(size);
        p.iterations.resize(size);
        p.neighbours.resize(size);
    };
    resize(sorted, m);
    const std::vector<Run> runs =
        split_into_runs(unit, longest_run, [&](int i) { return run_radius * data.cells.scales[cell[i]].width; });
    parallel_chunks(runs.size(), threads, 64, progress.part(0.2, 1, "Projection"),
                    [&](std::size_t begin, std::size_t end)
                    {
                        Projector projector(data, options);
                        for (std::size_t r = begin; r < end; ++r)
                        {
                            const Run& run = runs[r];
                            double width = 0;
                            for (int i = run.begin; i < run.end; ++i)
                                width = std::max(width, data.cells.scales[cell[i]].width);
                            for (int i = run.begin; i < run.end; ++i)
                            {
                                // Every point starts from the run's anchors: what one gathered anew must not leak into
                                // the next, or the result would depend on more than the point.
                                if (i == run.begin || !projector.is_fresh())
                                    projector.prepare(run.centre, run.radius, width);
                                projector.project(unit[i], cell[i], width, sorted, std::size_t(i));
                            }
                        }
                    });

    AmlsProjection result;
    resize(result, n);
    parallel_for(
        n, threads, {},
        [&](std::size_t i)
        {
            const std::size_t s = std::size_t(spatial.representative[i]);
            result.points[i] =
                sorted.status[s] == ProjectionStatus::outlier ? points[i] : data.frame.from_unit(sorted.points[s]);
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
