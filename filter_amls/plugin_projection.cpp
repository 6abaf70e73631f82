#include "plugin_filters.h"

#include "filter_amls/paper/delaunay_ball_normals.h"
#include "filter_amls/paper/feature_size.h"
#include "filter_amls/paper/plain_mls.h"
#include "filter_amls/surface/project.h"

#include <meshlab/shared_parameters.h>

#include <algorithm>
#include <chrono>

namespace
{

using recon::AmlsProjection;
using recon::AmlsSurface;
using recon::Points;
using recon::ProjectionStatus;
using recon::Vectors;
using recon::plugin_filters::add_report;
using recon::plugin_filters::citation;

double seconds_since(std::chrono::steady_clock::time_point start)
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

enum class NormalSource
{
    estimate,
    layer
};

enum class Weights
{
    anchors,
    paper_normalised,
    paper_plain
};

struct ProjectionFilterOptions
{
    std::string surface_layer;
    recon::AmlsOptions surface;
    NormalSource normals = NormalSource::estimate;
    Weights weights = Weights::anchors;
    int max_iterations = 0;
    double tolerance = recon::AmlsProjectionOptions().tolerance;
    double cut_off = 0;
    bool select_not_converged = false;
    bool remove_outliers = false;
    bool selected_only = false;
};

plugin::ParameterTable<ProjectionFilterOptions> projection_table()
{
    using Options = ProjectionFilterOptions;
    return plugin::ParameterTable<Options>()
        .number(
            "rho_e", [](Options& o) -> double& { return o.surface.rho_e; }, "Width (rho_e)",
            "Width of the Gaussian weights in local feature sizes. 0: chosen from noise, spacing and curvature, point "
            "by point; the result values tell which rho_e that amounts to. The paper uses 0.75.")
        .length(
            "noise", [](Options& o) -> double& { return o.surface.noise; }, "Noise",
            "Standard deviation of the noise. 0: estimated, locally.")
        .choice("normals", &Options::normals, {"estimate", "use the layer's"}, "Normals",
                "estimate: no normals are needed. use the layer's: the normals of the layer that defines the surface "
                "decide which side is outside.")
        .choice("weights", &Options::weights, {"anchors with curvature", "paper's normalised I", "paper's plain N"},
                "Weights",
                "anchors with curvature: small quadrics fitted to the points. paper's normalised I, paper's plain N: "
                "the functions of the paper over all points, with a much smaller domain of convergence for N. With "
                "these two neither noise nor outliers are looked for, and the result has no values of cells and "
                "anchors.")
        .count("max_iterations", &Options::max_iterations, "Iterations",
               "Newton steps per point. 0: 6, or 30 for the paper's.")
        .number("tolerance", &Options::tolerance, "Tolerance",
                "A point has converged when a step is shorter than this share of the local spacing of the points; for "
                "the paper's weights when its error is below a tenth of it in widths.")
        .number("cut_off", &Options::cut_off, "Cut-off",
                "What is farther than this many widths does not count. 0: 2.2 for anchors (at most 2.8), 5 for the "
                "paper's.")
        .flag(
            "remove_outliers", &Options::remove_outliers, "Remove outliers",
            "Delete isolated points. Otherwise they stay where they are and become the selection. Points too far from "
            "the surface of another layer are never deleted.")
        .flag("select_not_converged", &Options::select_not_converged, "Select what did not converge",
              "Select also the points whose projection has not converged.")
        .text("surface_layer", &Options::surface_layer, "Surface layer",
              "Name of the layer whose points define the surface. Empty: the current layer, all its points. Points "
              "farther from that surface than 0.9 local feature sizes, with none of it within reach of the weights, "
              "stay where they are, are selected and count as points_too_far.")
        .flag("selected_only", &Options::selected_only, "Selected vertices only",
              "Move only the selected vertices; the surface is defined by all.")
        .count(
            "threads", [](Options& o) -> int& { return o.surface.threads; }, "Threads", plugin::tooltips::threads);
}

/// What both kinds of projection tell.
struct Projected
{
    Points points;
    Vectors normals;
    std::vector<ProjectionStatus> status;
    double iterations = 0, neighbours = 0; // means
};

Projected project_to_anchors(const Points& queries, const Points& defining, const Vectors& normals, bool foreign_points,
                             const ProjectionFilterOptions& options, const recon::Progress& progress,
                             plugin::FilterResult& result)
{
    const AmlsSurface surface = build_amls_surface(defining, options.surface, progress.part(0, 0.7, ""), normals);
    recon::AmlsProjectionOptions how;
    how.threads = options.surface.threads;
    how.tolerance = options.tolerance;
    how.foreign_points = foreign_points;
    if (options.max_iterations != 0)
        how.max_iterations = options.max_iterations;
    if (options.cut_off != 0)
        how.cut_off = options.cut_off;
    const auto start = std::chrono::steady_clock::now();
    AmlsProjection found = project_to_amls(queries, surface, how, progress.part(0.7, 1, ""));
    add_report(surface.report(), result);
    result.values.emplace_back("seconds_projection", seconds_since(start));
    result.values.emplace_back("points_on_local_plane", found.count(ProjectionStatus::fell_back));
    Projected projected;
    for (std::size_t i = 0; i < queries.size(); ++i)
    {
        projected.iterations += found.iterations[i] / double(queries.size());
        projected.neighbours += found.neighbours[i] / double(queries.size());
    }
    projected.status = std::move(found.status);
    projected.points = std::move(found.points);
    projected.normals = std::move(found.normals);
    return projected;
}

Projected project_to_paper(const Points& queries, const Points& defining, const Vectors& normals,
                           const ProjectionFilterOptions& options, const recon::Progress& progress,
                           plugin::FilterResult& result)
{
    constexpr int smoothed_over = 20; // samples; poles scatter under noise
    recon::DelaunayBallOptions balls;
    balls.threads = options.surface.threads;
    auto start = std::chrono::steady_clock::now();
    recon::DelaunayBallNormals found = find_delaunay_ball_normals(defining, balls, progress.part(0, 0.3, ""));
    recon::OrientedSamples samples{defining, normals.empty() ? std::move(found.normals) : normals};
    for (recon::Vector& n : samples.normals)
        n.normalize();
    result.values.emplace_back("seconds_normals", seconds_since(start));
    start = std::chrono::steady_clock::now();
    recon::FeatureSizeOptions measure;
    measure.smoothing = smoothed_over;
    measure.threads = options.surface.threads;
    const std::vector<double> size =
        measure_feature_size(defining, found.poles, measure, progress.part(0.3, 0.35, "Feature size"));
    if (found.poles.empty())
        throw recon::AlgorithmFailure(
            "No Delaunay ball is big, so there is no feature size. Use the weights 'anchors with curvature'.");
    result.values.emplace_back("seconds_feature_size", seconds_since(start));
    start = std::chrono::steady_clock::now();
    recon::PlainMlsOptions how;
    how.threads = options.surface.threads;
    how.surface =
        options.weights == Weights::paper_plain ? recon::PlainSurface::plain_n : recon::PlainSurface::normalised;
    if (options.surface.rho_e != 0)
        how.rho_e = options.surface.rho_e;
    how.tolerance = options.tolerance * 0.1;
    if (options.max_iterations != 0)
        how.max_iterations = options.max_iterations;
    if (options.cut_off != 0)
        how.cut_off = options.cut_off;
    recon::PlainMlsProjection moved =
        project_to_plain_mls(queries, samples, size, how, progress.part(0.35, 1, "Projection"));
    result.values.emplace_back("seconds_projection", seconds_since(start));
    result.values.emplace_back("rho_e", how.rho_e);
    Projected projected;
    for (std::size_t i = 0; i < queries.size(); ++i)
    {
        projected.status.push_back(moved.neighbours[i] == 0 ? ProjectionStatus::too_far
                                   : moved.converged[i]     ? ProjectionStatus::converged
                                                            : ProjectionStatus::not_converged);
        projected.iterations += moved.iterations[i] / double(queries.size());
        projected.neighbours += moved.neighbours[i] / double(queries.size());
    }
    projected.points = std::move(moved.points);
    projected.normals = std::move(moved.normals);
    return projected;
}

plugin::FilterResult project_points(const plugin::InputLayer& layer, const ProjectionFilterOptions& options,
                                    const recon::Progress& progress)
{
    if (options.max_iterations < 0)
        throw recon::InvalidInput("The number of iterations must be 0 (automatic) or more.");
    const std::vector<int> used = plugin::vertices_to_use(layer, options.selected_only);
    const Points queries = plugin::pick(layer.points, used);
    const bool foreign_points = !options.surface_layer.empty() && options.surface_layer != layer.name;
    plugin::InputLayer other;
    if (foreign_points)
        other = layer.find_layer(options.surface_layer);
    const plugin::InputLayer& defining = foreign_points ? other : layer;
    Vectors normals;
    if (options.normals == NormalSource::layer)
    {
        std::vector<int> all(defining.points.size());
        for (std::size_t i = 0; i < all.size(); ++i)
            all[i] = int(i);
        normals = plugin::oriented_samples(defining, all).normals;
    }

    plugin::FilterResult result;
    Projected projected =
        options.weights == Weights::anchors
            ? project_to_anchors(queries, defining.points, normals, foreign_points, options, progress, result)
            : project_to_paper(queries, defining.points, normals, options, progress, result);

    const auto count = [&](ProjectionStatus wanted)
    { return int(std::count(projected.status.begin(), projected.status.end(), wanted)); };
    std::vector<char> selected(used.size(), 0);
    for (std::size_t i = 0; i < used.size(); ++i)
    {
        const ProjectionStatus status = projected.status[i];
        selected[i] = status == ProjectionStatus::outlier || status == ProjectionStatus::too_far ||
                      (options.select_not_converged && status == ProjectionStatus::not_converged);
        if (status == ProjectionStatus::outlier && options.remove_outliers)
            result.removed.push_back(used[i]);
    }
    result.changed.vertices = used;
    result.changed.points = std::move(projected.points);
    result.changed.normals = std::move(projected.normals);
    result.changed.selected = std::move(selected);
    result.values.emplace_back("points_projected",
                               int(std::count_if(projected.status.begin(), projected.status.end(), recon::is_moved)));
    result.values.emplace_back("outliers", count(ProjectionStatus::outlier));
    result.values.emplace_back("points_kept", count(ProjectionStatus::kept));
    result.values.emplace_back("points_too_far", count(ProjectionStatus::too_far));
    result.values.emplace_back("points_not_converged", count(ProjectionStatus::not_converged));
    result.values.emplace_back("mean_iterations", projected.iterations);
    result.values.emplace_back("mean_neighbours", projected.neighbours);
    return result;
}

} // namespace

plugin::FilterSpec recon::plugin_filters::describe_projection()
{
    plugin::FilterSpec spec;
    spec.name = "MLS projection (AMLS)";
    spec.python_name = "compute_mls_projection_amls";
    spec.info =
        std::string(
            "Removes <b>noise</b> from a point cloud by moving its points onto a smooth surface through them. <b>No "
            "normals and no parameters are needed</b>: noise, spacing and curvature are estimated locally and set the "
            "width of the weights. The normals become those of the surface. Isolated points are not moved but "
            "selected. The points may also be moved onto the surface of another layer.<br><br>") +
        citation;
    spec.category = plugin::Category::smoothing | plugin::Category::point_set;
    spec.effects = plugin::Effect::moves_vertices | plugin::Effect::changes_normals |
                   plugin::Effect::changes_selection | plugin::Effect::removes_vertices;
    spec.compute_with(projection_table(), project_points);
    return spec;
}
