#include "plugin_filters.h"

#include "filter_amls/normals/outward_normals.h"
#include "filter_amls/paper/delaunay_ball_normals.h"
#include "filter_amls/surface/local_feature_size.h"
#include "filter_amls/surface/project.h"

#include <meshlab/shared_parameters.h>
#include <recon/crust/weaving.h>
#include <recon/median.h>

#include <algorithm>
#include <cmath>

namespace
{

using recon::AmlsProjection;
using recon::AmlsSurface;
using recon::Points;
using recon::plugin_filters::add_report;
using recon::plugin_filters::citation;

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
        .flag("selected_only", &Options::selected_only, "Selected vertices only", plugin::tooltips::selected_only)
        .count("threads", &Options::threads, "Threads", plugin::tooltips::threads);
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
    recon::OutwardNormals found = find_outward_normals(points, surface_options(options.threads), progress);
    result.changed.normals = std::move(found.normals);
    add_report(found.surface, result);
    result.values.emplace_back("exact", found.is_exact);
    result.values.emplace_back("normals_of_crust", found.of_crust);
    if (found.lies_between_sheets)
        result.log.push_back(recon::out_of_register_text);
    return result;
}

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
        add_report(surface.report(), result);
    }
    const auto [smallest, largest] = std::minmax_element(sizes.begin(), sizes.end());
    result.values.emplace_back("min_feature_size", *smallest);
    result.values.emplace_back("median_feature_size", recon::median(sizes));
    result.values.emplace_back("max_feature_size", *largest);
    result.values.emplace_back("poles", poles);
    result.changed.vertices = used;
    if (options.colorize)
    {
        const double low = recon::quantile(sizes, 0.02), high = recon::quantile(sizes, 0.98);
        for (double size : sizes)
            result.changed.colours.push_back(colour_of(high > low ? (size - low) / (high - low) : 0.5));
    }
    result.changed.quality = std::move(sizes);
    return result;
}

} // namespace

plugin::FilterSpec recon::plugin_filters::describe_normals()
{
    plugin::FilterSpec spec;
    spec.name = "Compute normals from Delaunay balls";
    spec.python_name = "compute_normal_from_delaunay_balls";
    spec.info =
        std::string(
            "Computes <b>outward unit normals</b> of a point cloud that may be <b>noisy</b> and has no "
            "normals yet. Which side is outside follows from the Delaunay balls of the cloud, not from a "
            "viewpoint or from walking over neighbours; where the cloud is closed a crust of it, which knows "
            "both sides of thin walls, corrects them. What a depth camera or laser scanner saw is "
            "recognised, from the origin or by the order of the points, and faces it; of several scans, one after the "
            "other, each its own. Points are not moved.<br><br>") +
        citation;
    spec.category = plugin::Category::normal | plugin::Category::point_set;
    spec.effects = plugin::Effect::changes_normals;
    spec.compute_with(ball_table<BallOptions>(), compute_normals);
    return spec;
}

plugin::FilterSpec recon::plugin_filters::describe_feature_size()
{
    plugin::FilterSpec spec;
    spec.name = "Compute local feature size";
    spec.python_name = "compute_scalar_by_local_feature_size";
    spec.info =
        std::string(
            "Stores in the vertex quality the <b>local feature size</b>: the distance to the medial axis, that "
            "is to the nearest pole (centre of a big Delaunay ball). It is small at thin parts, at high "
            "curvature and where two sheets come close, and tells how densely a surface must be sampled.<br><br>") +
        citation;
    spec.category = plugin::Category::quality | plugin::Category::point_set;
    spec.effects = plugin::Effect::changes_quality | plugin::Effect::changes_colours;
    spec.compute_with(
        ball_table<FeatureSizeFilterOptions>()
            .count("smoothing", &FeatureSizeFilterOptions::smoothing, "Smoothing",
                   "Number of nearest points over which the value is averaged. 0: not at all.")
            .flag("colorize", &FeatureSizeFilterOptions::colorize, "Colorize",
                  "Colour the vertices: blue for the smallest values, through green, to red for the largest."),
        compute_feature_size);
    return spec;
}
