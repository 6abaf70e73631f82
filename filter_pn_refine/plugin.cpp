#include "refine.h"
#include "sharpen_normals.h"

#include "filter_amls/cells/isolated_points.h"
#include "filter_amls/normals/outward_normals.h"

#include <meshlab/filter_spec.h>
#include <meshlab/shared_parameters.h>

#include <recon/errors.h>
#include <recon/progress.h>

#include <algorithm>
#include <cmath>

namespace
{

struct Options : recon::PnRefineOptions
{
    bool selected_only = false;
    bool into_new_layer = true;
};

plugin::ParameterTable<Options> table()
{
    return plugin::ParameterTable<Options>()
        .count("steps", &Options::steps, "Steps",
               "Refinement steps, 0 to 30. Each makes about two to three times as many points. 0: only edges and holes "
               "get points.")
        .length("target_radius", &Options::target_radius, "Target radius",
                "Where the points' radii are at most this, refinement stops. 0: off.")
        .choice(
            "neighbourhood", &Options::neighbourhood, {"automatic", "fast fuzzy BSP", "accurate geodesic"},
            "Neighbourhood",
            "How the neighbours of a point are chosen. The accurate one copes better with few samples on curved parts; "
            "automatic uses it only there. Does nothing where 'fast' is on.")
        .flag("fast", &Options::fast, "Fast",
              "Shortcuts that cost accuracy only where the samples are few; folds that they show too sparsely and "
              "voids between them stay open.")
        .length(
            "initial_radius", &Options::initial_radius, "Initial radius",
            "Radius of each point at the start; it must reach the point's neighbours, and counts up to four times what "
            "would be found for the point. 0: the layer's radii if it has them, else found for each point.")
        .length("hole_radius", &Options::hole_radius, "Hole radius",
                "Holes from three spacings of the points up to this radius are filled smoothly, as densely as the "
                "points around; so are bays of an outer rim. Wider ones stay open, from some 1.5 times it on; if "
                "nothing is filled, a warning says so. 0: off.")
        .number("boundary_angle", &Options::boundary_angle, "Boundary angle",
                "A point belongs to a rim if two successive neighbours enclose a larger angle, 120 to 180 degrees.")
        .number("crease_angle", &Options::crease_angle, "Crease angle",
                "Normals that differ by more make a crease, 0 to 180 degrees.")
        .flag("detect_creases", &Options::detect_creases, "Detect creases",
              "Puts crease points onto edges where two faces end sharply at more than the crease angle, as the normals "
              "show; smooth shapes and noisy normals show none. Off: creases are only where two vertices share one "
              "position.")
        .flag("preserve_boundaries", &Options::preserve_boundaries, "Preserve boundaries",
              "Refines rims along their own curves.")
        .flag("preserve_creases", &Options::preserve_creases, "Preserve creases",
              "Refines creases along their own curves; each new crease point is two vertices with both normals.")
        .flag("repair_normals", &Options::repair_normals, "Repair normals",
              "Turns normals over that most neighbours contradict.")
        .count(
            "max_points", &Options::max_points, "Largest number of points",
            "What would make more points in all, a step or what is put onto edges and into holes before, is not done.")
        .flag("selected_only", &Options::selected_only, "Selected vertices only",
              "Refines only around the selected vertices; the others are neighbours only and keep their normals.")
        .flag("into_new_layer", &Options::into_new_layer, "Into new layer",
              "The refined point set, without faces, becomes a new layer. Off: the new vertices are appended to the "
              "current layer, whose faces stay as they are.")
        .count("threads", &Options::threads, "Threads", plugin::tooltips::threads);
}

bool has_normals(const plugin::InputLayer& layer)
{
    return std::any_of(layer.normals.begin(), layer.normals.end(),
                       [](const recon::Vector& n) { return n.allFinite() && n.squaredNorm() > 0; });
}

/// As 'Compute normals from Delaunay balls' does by default: the paper's normals turn over in patches where there is
/// noise, or a rim.
recon::Vectors compute_normals(const recon::Points& points, int threads, const recon::Progress& progress)
{
    recon::AmlsOptions surface;
    surface.threads = threads;
    try
    {
        return recon::find_outward_normals(points, surface, progress).normals;
    }
    catch (const recon::InvalidInput& problem) // of flat clouds, which can be refined all the same
    {
        throw recon::InvalidInput(std::string(problem.what()) +
                                  " Or give the layer normals, for example with the filter 'Compute normals for point "
                                  "sets': it has none, and Delaunay balls do not tell them here.");
    }
}

std::vector<plugin::Colour> interpolate_colours(const recon::PnRefinement& refined,
                                                const std::vector<plugin::Colour>& input)
{
    if (input.empty())
        return {};
    std::vector<Eigen::Array4f> values;
    values.reserve(input.size());
    for (const plugin::Colour& c : input)
        values.emplace_back(c[0], c[1], c[2], c[3]);
    std::vector<plugin::Colour> colours;
    colours.reserve(refined.points.size());
    for (const Eigen::Array4f& v : recon::interpolate(refined, values))
    {
        plugin::Colour c;
        for (int k = 0; k < 4; ++k)
            c[std::size_t(k)] = std::uint8_t(std::lround(std::clamp(v[k], 0.f, 255.f)));
        colours.push_back(c);
    }
    return colours;
}

template <class T>
void append(std::vector<T>& to, const std::vector<T>& more)
{
    to.insert(to.end(), more.begin(), more.end());
}

void describe(const recon::PnRefinement& refined, plugin::FilterResult& result)
{
    for (std::size_t k = 0; k < refined.steps.size(); ++k)
        result.values.emplace_back("points_step_" + std::to_string(k + 1), refined.steps[k].points);
    double seconds = 0;
    for (const auto& phase : refined.seconds)
        seconds += phase.second;
    const recon::PnStepStatistics& last = refined.at_end;
    append(result.values, {{"new_points", int(refined.points.size())},
                           {"smallest_radius", last.smallest_radius},
                           {"median_radius", last.median_radius},
                           {"largest_radius", last.largest_radius},
                           {"open_gaps", last.open_gaps},
                           {"boundary_segments", refined.boundary_segments},
                           {"crease_segments", refined.crease_segments},
                           {"crease_points", refined.crease_points},
                           {"hole_points", refined.hole_points},
                           {"void_points", refined.void_points},
                           {"fold_points", refined.fold_points},
                           {"turned_normals", int(refined.turned_normals.size())},
                           {"left_out", refined.left_out},
                           {"new_points_per_second", seconds > 0 ? double(refined.points.size()) / seconds : 0.0}});
    plugin::append_seconds(result, refined.seconds);
    append(result.warnings, refined.warnings);
}

plugin::FilterResult refine(const plugin::InputLayer& layer, const Options& options, const recon::Progress& progress)
{
    plugin::vertices_to_use(layer, options.selected_only); // throws if there are none
    plugin::FilterResult result;
    recon::OrientedSamples samples{layer.points, layer.normals};
    const bool own_normals = has_normals(layer);
    recon::PhaseTimes times; // of what comes before refinement itself
    if (!own_normals)
    {
        times.begin("normals");
        samples.normals = compute_normals(layer.points, options.threads, progress.part(0, 0.25, "normals"));
        if (options.detect_creases)
            samples.normals = recon::pn::sharpen_normals(samples, options, progress.part(0.25, 0.3, "normals"));
        result.warnings.push_back("The layer has no normals: they were computed from Delaunay balls.");
    }
    recon::PnRefineHints hints;
    hints.radii = layer.radii;
    times.begin("isolated points");
    // Refinement itself sees only those that have no others beside them.
    const double begin = own_normals ? 0 : 0.3;
    hints.is_isolated = recon::mark_isolated_points(layer.points, options.threads,
                                                    progress.part(begin, begin + 0.1, "isolated points"));
    times.end();
    if (options.selected_only)
        hints.is_refined = layer.selected;
    recon::PnRefinement refined =
        recon::refine_points(samples, options, hints, progress.part(begin + 0.1, 1, "refining"));
    refined.seconds.insert(refined.seconds.begin(), times.seconds().begin(), times.seconds().end());
    describe(refined, result);
    if (options.steps > 0 && refined.points.empty())
        result.warnings.push_back("No point was added. Usual causes: an initial radius far from the points' spacing, a "
                                  "target radius that is reached already, a small largest number of points.");

    std::vector<plugin::Colour> colours = interpolate_colours(refined, layer.colours);
    std::vector<double> quality;
    if (!layer.quality.empty())
        quality = recon::interpolate(refined, layer.quality);
    for (int i : refined.turned_normals)
        samples.normals[std::size_t(i)] = -samples.normals[std::size_t(i)];

    if (options.into_new_layer)
    {
        plugin::NewLayer made;
        made.name = plugin::name_without_ending(layer) + " refined";
        made.mesh.vertices = layer.points;
        append(made.mesh.vertices, refined.points);
        made.normals = std::move(samples.normals);
        append(made.normals, refined.normals);
        if (!colours.empty())
        {
            made.colours = layer.colours;
            append(made.colours, colours);
        }
        if (!quality.empty())
        {
            made.quality = layer.quality;
            append(made.quality, quality);
        }
        made.radii = std::move(refined.input_radii);
        append(made.radii, refined.radii);
        result.new_layers.push_back(std::move(made));
        return result;
    }
    const int n = int(layer.points.size());
    result.changed.vertices.resize(std::size_t(n));
    for (int i = 0; i < n; ++i)
        result.changed.vertices[std::size_t(i)] = i;
    result.changed.radii = std::move(refined.input_radii);
    if (!own_normals || !refined.turned_normals.empty())
        result.changed.normals = std::move(samples.normals);
    result.appended.points = std::move(refined.points);
    result.appended.normals = std::move(refined.normals);
    result.appended.radii = std::move(refined.radii);
    result.appended.colours = std::move(colours);
    result.appended.quality = std::move(quality);
    return result;
}

} // namespace

plugin::PluginSpec plugin::describe_plugin()
{
    FilterSpec filter;
    filter.name = "Point Cloud Refinement: PN Triangles";
    filter.python_name = "meshing_point_cloud_refinement_pn";
    filter.info = "Makes a sparse <b>point cloud with normals</b> dense and smooth. The points stay where they are; "
                  "between them new ones are put onto curved triangles that follow the normals, step by step, until "
                  "the cloud looks like a surface. New vertices get position, normal, radius, and colour and quality "
                  "between those of their neighbours. Sharp edges, which are found or given (two vertices at one "
                  "position with different normals), and rims are kept, holes can be filled.<br>"
                  "Without normals, they are computed from Delaunay balls first.<br><br>"
                  "See:<br><i>G. Guennebaud, L. Barthe, M. Paulin</i><br>"
                  "<b>\"Interpolatory Refinement for Real-Time Processing of Point-Based Geometry\"</b><br>"
                  "Computer Graphics Forum 24 (Eurographics 2005).<br>";
    filter.category = Category::remeshing | Category::point_set;
    filter.effects = Effect::makes_layer | Effect::appends_vertices | Effect::changes_normals | Effect::changes_radii;
    filter.compute_with(table(), refine);
    return {"PN Refinement", {filter}};
}
