#include "delaunay_ball_normals.h"
#include "local_feature_size.h"
#include "plain_mls.h"
#include "project.h"
#include "reconstruct_amls.h"

#include <meshlab/filter_spec.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace
{

using recon::AmlsProjection;
using recon::AmlsSurface;
using recon::Point;
using recon::Points;
using recon::ProjectionStatus;
using recon::Vectors;

constexpr char citation[] = "See:<br><i>T. K. Dey, J. Sun</i><br>"
                            "<b>\"An Adaptive MLS Surface for Reconstruction with Guarantees\"</b><br>"
                            "Eurographics Symposium on Geometry Processing 2005.<br>";

enum class Method
{
    automatic,
    paper
};

/// What normals and feature sizes have in common.
struct BallOptions
{
    Method method = Method::automatic;
    double big_ball_ratio = recon::DelaunayBallOptions().big_ball_ratio;
    int neighbours = recon::DelaunayBallOptions().neighbours;
    bool selected_only = false;
    int threads = recon::AmlsOptions().threads;
};

template <class Options>
plugin::ParameterTable<Options> ball_table()
{
    return plugin::ParameterTable<Options>()
        .choice(
            "method", &Options::method, {"automatic", "paper"}, "Method",
            "automatic: points are averaged into cells, thinned to anchors, and the Delaunay balls of the anchors tell "
            "inside from outside. paper: the biggest big Delaunay ball at each point.")
        .number("big_ball_ratio", &Options::big_ball_ratio, "Big ball ratio",
                "Method 'paper' only: a ball is big if its radius exceeds this times the mean distance to the nearest "
                "points (the paper's c = 2.5). 0: 2.5, but above the noise.")
        .count("neighbours", &Options::neighbours, "Neighbours",
               "Method 'paper' only: number of nearest points of that mean distance. 0: 5, as in the paper.")
        .flag("selected_only", &Options::selected_only, "Selected vertices only", "Use only the selected vertices.")
        .count("threads", &Options::threads, "Threads",
               "Number of threads, 0: one per core. The result does not depend on it.");
}

recon::DelaunayBallOptions paper_options(const BallOptions& options)
{
    recon::DelaunayBallOptions paper;
    paper.big_ball_ratio = options.big_ball_ratio;
    paper.neighbours = options.neighbours;
    paper.threads = options.threads;
    return paper;
}

recon::AmlsOptions surface_options(int threads)
{
    recon::AmlsOptions options;
    options.threads = threads;
    return options;
}

AmlsProjection project(const Points& points, const AmlsSurface& surface, int threads, const recon::Progress& progress)
{
    recon::AmlsProjectionOptions options;
    options.threads = threads;
    return project_to_amls(points, surface, options, progress);
}

void add_report(const AmlsSurface& surface, plugin::FilterResult& result)
{
    const recon::AmlsSurfaceReport& report = surface.report();
    result.values.emplace_back("noise", report.noise);
    result.values.emplace_back("spacing", report.spacing);
    result.values.emplace_back("width", report.width);
    result.values.emplace_back("rho_e", report.rho_e);
    result.values.emplace_back("cells", report.cells);
    result.values.emplace_back("anchors", report.anchors);
    result.values.emplace_back("open", report.open);
    plugin::append_seconds(result, report.seconds);
    if (report.open)
        result.log.push_back(
            "The points are an open sheet without inside and outside: normals are consistent across it, "
            "but which side they point to has no meaning.");
}

double seconds_since(std::chrono::steady_clock::time_point start)
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Value at the given share of the sorted values.
double quantile(std::vector<double> values, double share)
{
    if (values.empty())
        return 0;
    const auto place = values.begin() + std::ptrdiff_t(share * double(values.size() - 1) + 0.5);
    std::nth_element(values.begin(), place, values.end());
    return *place;
}

// Normals
// ----------------------------------------------------------------------------------------------------------------

plugin::FilterResult compute_normals(const plugin::InputLayer& layer, const BallOptions& options,
                                     const recon::Progress& progress)
{
    const std::vector<int> used = plugin::vertices_to_use(layer, options.selected_only);
    const Points points = plugin::pick(layer.points, used);
    plugin::FilterResult result;
    result.changed.vertices = used;
    if (options.method == Method::paper)
    {
        recon::DelaunayBallNormals found = find_delaunay_ball_normals(points, paper_options(options), progress);
        result.changed.normals = std::move(found.normals);
        result.values.emplace_back("points_with_big_ball", found.with_big_ball);
        return result;
    }
    const AmlsSurface surface = build_amls_surface(points, surface_options(options.threads), progress.part(0, 0.8, ""));
    AmlsProjection projection = project(points, surface, options.threads, progress.part(0.8, 1, ""));
    result.changed.normals = std::move(projection.normals);
    add_report(surface, result);
    return result;
}

// Local feature size
// -----------------------------------------------------------------------------------------------------

struct FeatureSizeFilterOptions : BallOptions
{
    int smoothing = recon::FeatureSizeOptions().smoothing;
    bool colorize = false;
};

/// Blue for the smallest, through green, to red for the largest.
plugin::Colour colour_of(double share)
{
    const auto byte = [](double value) { return std::uint8_t(std::lround(255 * std::clamp(value, 0.0, 1.0))); };
    const double x = 4 * std::clamp(share, 0.0, 1.0);
    return {byte(x - 2), byte(std::min(x, 4 - x)), byte(2 - x), 255};
}

plugin::FilterResult compute_feature_size(const plugin::InputLayer& layer, const FeatureSizeFilterOptions& options,
                                          const recon::Progress& progress)
{
    const std::vector<int> used = plugin::vertices_to_use(layer, options.selected_only);
    const Points points = plugin::pick(layer.points, used);
    recon::FeatureSizeOptions measure;
    measure.smoothing = options.smoothing;
    measure.threads = options.threads;

    plugin::FilterResult result;
    std::vector<double> sizes;
    int poles = 0;
    if (options.method == Method::paper)
    {
        const recon::DelaunayBallNormals found =
            find_delaunay_ball_normals(points, paper_options(options), progress.part(0, 0.9, ""));
        poles = int(found.poles.size());
        if (found.poles.empty())
            throw recon::AlgorithmFailure("No Delaunay ball of the points is big. Lower the ratio of a big ball.");
        sizes = measure_feature_size(points, found.poles, measure, progress.part(0.9, 1, "Feature size"));
    }
    else
    {
        const AmlsSurface surface =
            build_amls_surface(points, surface_options(options.threads), progress.part(0, 0.6, ""));
        const AmlsProjection projection = project(points, surface, options.threads, progress.part(0.6, 0.7, ""));
        recon::LocalFeatureSize found =
            find_local_feature_size(projection.points, surface, measure, progress.part(0.7, 1, ""));
        poles = int(found.poles.size());
        sizes = std::move(found.at_query);
        add_report(surface, result);
    }
    const auto [smallest, largest] = std::minmax_element(sizes.begin(), sizes.end());
    result.values.emplace_back("min_feature_size", *smallest);
    result.values.emplace_back("median_feature_size", quantile(sizes, 0.5));
    result.values.emplace_back("max_feature_size", *largest);
    result.values.emplace_back("poles", poles);
    result.changed.vertices = used;
    if (options.colorize)
    {
        const double low = quantile(sizes, 0.02), high = quantile(sizes, 0.98);
        for (double size : sizes)
            result.changed.colours.push_back(colour_of(high > low ? (size - low) / (high - low) : 0.5));
    }
    result.changed.quality = std::move(sizes);
    return result;
}

// Projection
// -------------------------------------------------------------------------------------------------------------

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
            "rho_e", [](Options& o) -> double& { return o.surface.rho_e; }, "rho_e",
            "Width of the Gaussian weights in local feature sizes. 0: chosen from noise, spacing and curvature, point "
            "by "
            "point; the result values tell which rho_e that amounts to. The paper uses 0.75.")
        .length(
            "noise", [](Options& o) -> double& { return o.surface.noise; }, "Noise",
            "Standard deviation of the noise. 0: estimated, locally.")
        .choice("normals", &Options::normals, {"estimate", "use the layer's"}, "Normals",
                "estimate: no normals are needed. use the layer's: the normals of the layer that defines the surface "
                "decide "
                "which side is outside.")
        .choice(
            "weights", &Options::weights, {"anchors with curvature", "paper's normalised I", "paper's plain N"},
            "Weights",
            "anchors with curvature: small quadrics fitted to averaged points. paper's normalised I, paper's plain N: "
            "the functions of the paper over all points, with a much smaller domain of convergence for N.")
        .count("max_iterations", &Options::max_iterations, "Iterations",
               "Newton steps per point. 0: 6, or 30 for the paper's.")
        .number("tolerance", &Options::tolerance, "Tolerance",
                "A point has converged when a step is shorter than this share of the local spacing of the points.")
        .number("cut_off", &Options::cut_off, "Cut-off",
                "What is farther than this many widths does not count. 0: 2.2 for anchors (at most 2.8), 5 for the "
                "paper's.")
        .flag("remove_outliers", &Options::remove_outliers, "Remove outliers",
              "Delete isolated points. Otherwise they are selected and never moved.")
        .flag("select_not_converged", &Options::select_not_converged, "Select what did not converge",
              "Select also the points whose projection has not converged.")
        .text("surface_layer", &Options::surface_layer, "Surface layer",
              "Name of the layer whose points define the surface. Empty: the current layer, all its points.")
        .flag("selected_only", &Options::selected_only, "Selected vertices only",
              "Move only the selected vertices; the surface is defined by all.")
        .count(
            "threads", [](Options& o) -> int& { return o.surface.threads; }, "Threads",
            "Number of threads, 0: one per core. The result does not depend on it.");
}

/// What both kinds of projection tell.
struct Projected
{
    Points points;
    Vectors normals;
    std::vector<char> outlier, converged;
    double iterations = 0, neighbours = 0; // means
};

Projected project_to_anchors(const Points& queries, const Points& defining, const Vectors& normals,
                             const ProjectionFilterOptions& options, const recon::Progress& progress,
                             plugin::FilterResult& result)
{
    const AmlsSurface surface = build_amls_surface(defining, options.surface, progress.part(0, 0.7, ""), normals);
    recon::AmlsProjectionOptions how;
    how.threads = options.surface.threads;
    how.tolerance = options.tolerance;
    how.foreign_points = !options.surface_layer.empty();
    if (options.max_iterations != 0)
        how.max_iterations = options.max_iterations;
    if (options.cut_off != 0)
        how.cut_off = options.cut_off;
    const auto start = std::chrono::steady_clock::now();
    AmlsProjection found = project_to_amls(queries, surface, how, progress.part(0.7, 1, ""));
    add_report(surface, result);
    result.values.emplace_back("seconds_projection", seconds_since(start));
    result.values.emplace_back("points_on_local_plane", found.count(ProjectionStatus::fell_back));
    Projected projected;
    for (std::size_t i = 0; i < queries.size(); ++i)
    {
        projected.outlier.push_back(found.status[i] == ProjectionStatus::outlier);
        projected.converged.push_back(found.status[i] != ProjectionStatus::not_converged);
        projected.iterations += found.iterations[i] / double(queries.size());
        projected.neighbours += found.neighbours[i] / double(queries.size());
    }
    projected.points = std::move(found.points);
    projected.normals = std::move(found.normals);
    return projected;
}

Projected project_to_paper(const Points& queries, const Points& defining, const Vectors& normals,
                           const ProjectionFilterOptions& options, const recon::Progress& progress,
                           plugin::FilterResult& result)
{
    constexpr double paper_rho = 0.75;
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
    how.rho_e = options.surface.rho_e > 0 ? options.surface.rho_e : paper_rho;
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
    projected.outlier.assign(queries.size(), 0);
    for (std::size_t i = 0; i < queries.size(); ++i)
    {
        projected.iterations += moved.iterations[i] / double(queries.size());
        projected.neighbours += moved.neighbours[i] / double(queries.size());
    }
    projected.converged = std::move(moved.converged);
    projected.points = std::move(moved.points);
    projected.normals = std::move(moved.normals);
    return projected;
}

plugin::FilterResult project_points(const plugin::InputLayer& layer, const ProjectionFilterOptions& options,
                                    const recon::Progress& progress)
{
    const std::vector<int> used = plugin::vertices_to_use(layer, options.selected_only);
    const Points queries = plugin::pick(layer.points, used);
    plugin::InputLayer other;
    if (!options.surface_layer.empty())
        other = layer.find_layer(options.surface_layer);
    const plugin::InputLayer& defining = options.surface_layer.empty() ? layer : other;
    Vectors normals;
    if (options.normals == NormalSource::layer)
    {
        std::vector<int> all(defining.points.size());
        for (std::size_t i = 0; i < all.size(); ++i)
            all[i] = int(i);
        normals = plugin::oriented_samples(defining, all).normals;
    }

    plugin::FilterResult result;
    Projected projected = options.weights == Weights::anchors
                              ? project_to_anchors(queries, defining.points, normals, options, progress, result)
                              : project_to_paper(queries, defining.points, normals, options, progress, result);

    int outliers = 0, not_converged = 0;
    std::vector<char> selected(used.size(), 0);
    for (std::size_t i = 0; i < used.size(); ++i)
    {
        outliers += projected.outlier[i];
        not_converged += !projected.converged[i];
        selected[i] = projected.outlier[i] || (options.select_not_converged && !projected.converged[i]);
        if (projected.outlier[i] && options.remove_outliers)
            result.removed.push_back(used[i]);
    }
    result.changed.vertices = used;
    result.changed.points = std::move(projected.points);
    result.changed.normals = std::move(projected.normals);
    if (!options.remove_outliers || options.select_not_converged)
        result.changed.selected = std::move(selected);
    result.values.emplace_back("points_projected", int(used.size()) - outliers);
    result.values.emplace_back("outliers", outliers);
    result.values.emplace_back("points_not_converged", not_converged);
    result.values.emplace_back("mean_iterations", projected.iterations);
    result.values.emplace_back("mean_neighbours", projected.neighbours);
    return result;
}

struct ReconstructionFilterOptions : recon::AmlsReconstructionOptions
{
    bool selected_only = false;
};

plugin::ParameterTable<ReconstructionFilterOptions> reconstruction_table()
{
    using Options = ReconstructionFilterOptions;
    return plugin::ParameterTable<Options>()
        .number("rho_e", &Options::rho_e, "Width",
                "Width of the Gaussian weights in local feature sizes (the paper uses 0.75). 0: automatic, from noise, spacing "
                "and curvature.")
        .length("noise", &Options::noise, "Noise", "Standard deviation of the noise of the points. 0: estimated.")
        .choice("keep_components", &Options::keep_components, {"largest", "all"}, "Keep components",
                "Stray shells are dropped by keeping only the component that encloses the largest volume.")
        .flag("simplify", &Options::simplify, "Simplify",
              "Collapse short edges, to about one vertex per sample. The topology stays.")
        .flag("selected_only", &Options::selected_only, "Selected vertices only", "Use only the selected vertices.")
        .count("threads", &Options::threads, "Threads",
               "Number of threads, 0: one per core. The result does not depend on it.");
}

plugin::FilterResult reconstruct(const plugin::InputLayer& layer, const ReconstructionFilterOptions& options,
                                 const recon::Progress& progress)
{
    const std::vector<int> used = plugin::vertices_to_use(layer, options.selected_only);
    recon::AmlsReconstruction found = recon::reconstruct_amls(plugin::pick(layer.points, used), options, progress);

    plugin::FilterResult result;
    result.values = {
        {"noise", found.surface.noise},     {"spacing", found.surface.spacing},
        {"rho_e", found.surface.rho_e},     {"samples", found.samples},
        {"outliers", found.outliers},       {"vertices_on_surface", found.vertices_on_surface},
        {"components", found.components},   {"euler_characteristic", found.euler_characteristic},
        {"genus", found.genus},             {"violated_votes", found.violated_votes},
        {"open", found.surface.open},
    };
    plugin::append_seconds(result, found.seconds);

    plugin::NewLayer surface;
    surface.name = "AMLS surface of " + plugin::name_without_ending(layer);
    surface.mesh = std::move(found.mesh);
    surface.source = plugin::pick(used, found.nearest_sample);
    result.new_layers.push_back(std::move(surface));
    return result;
}

} // namespace

plugin::PluginSpec plugin::describe_plugin()
{
    FilterSpec normals;
    normals.name = "Compute normals from Delaunay balls";
    normals.python_name = "compute_normal_from_delaunay_balls";
    normals.info =
        std::string("Computes <b>outward unit normals</b> of a point cloud that may be <b>noisy</b> and has no "
                    "normals yet. Which side is outside follows from the Delaunay balls of the cloud, not from a "
                    "viewpoint or from walking over neighbours. Points are not moved.<br><br>") +
        citation;
    normals.category = Category::normal | Category::point_set;
    normals.effects = Effect::changes_normals;
    normals.compute_with(ball_table<BallOptions>(), compute_normals);

    FilterSpec size;
    size.name = "Compute local feature size";
    size.python_name = "compute_scalar_by_local_feature_size";
    size.info =
        std::string(
            "Stores in the vertex quality the <b>local feature size</b>: the distance to the medial axis, that "
            "is to the nearest pole (centre of a big Delaunay ball). It is small at thin parts, at high "
            "curvature and where two sheets come close, and tells how densely a surface must be sampled.<br><br>") +
        citation;
    size.category = Category::quality | Category::point_set;
    size.effects = Effect::changes_quality | Effect::changes_colours;
    size.compute_with(
        ball_table<FeatureSizeFilterOptions>()
            .count("smoothing", &FeatureSizeFilterOptions::smoothing, "Smoothing",
                   "Number of nearest points over which the value is averaged. 0: not at all.")
            .flag("colorize", &FeatureSizeFilterOptions::colorize, "Colorize",
                  "Colour the vertices: blue for the smallest values, through green, to red for the largest."),
        compute_feature_size);

    FilterSpec projection;
    projection.name = "MLS projection (AMLS)";
    projection.python_name = "compute_mls_projection_amls";
    projection.info =
        std::string(
            "Removes <b>noise</b> from a point cloud by moving its points onto a smooth surface through them. <b>No "
            "normals and no parameters are needed</b>: noise, spacing and curvature are estimated locally and set the "
            "width of the weights. The normals become those of the surface. Isolated points are not moved but "
            "selected. The points may also be moved onto the surface of another layer.<br><br>") +
        citation;
    projection.category = Category::smoothing | Category::point_set;
    projection.effects =
        Effect::moves_vertices | Effect::changes_normals | Effect::changes_selection | Effect::removes_vertices;
    projection.compute_with(projection_table(), project_points);

    FilterSpec reconstruction;
    reconstruction.name = "Surface Reconstruction: AMLS";
    reconstruction.python_name = "generate_surface_reconstruction_amls";
    reconstruction.info =
        std::string(
            "Makes a <b>smooth closed surface</b> from points that are <b>noisy</b> and have <b>no normals</b>: the points are "
            "moved onto their AMLS surface and thinned, a power crust of them gives the triangles, and its vertices are put on "
            "the AMLS surface. Holes of the scan are closed. Nothing needs to be tuned.<br><br>") +
        citation;
    reconstruction.category = Category::remeshing | Category::point_set;
    reconstruction.effects = Effect::makes_layer;
    reconstruction.compute_with(reconstruction_table(), reconstruct);

    return {"AMLS", {normals, size, projection, reconstruction}};
}
