#include "medial_axis.h"
#include "reconstruct.h"

#include <meshlab/filter_spec.h>
#include <meshlab/shared_parameters.h>
#include <recon/mesh/convex_surface.h>

namespace
{

constexpr char sgp_2005[] = "<i>B. Mederos, N. Amenta, L. Velho, L. H. de Figueiredo</i><br>"
                            "<b>\"Surface Reconstruction from Noisy Point Clouds\"</b><br>"
                            "Eurographics Symposium on Geometry Processing 2005.<br>";

struct Options : recon::NoisyPowerCrustOptions
{
    bool selected_only = false;
};

plugin::ParameterTable<Options> table()
{
    return plugin::ParameterTable<Options>()
        .flag("open_holes", &Options::open_holes, "Leave holes open", plugin::tooltips::open_holes)
        .length("ball_threshold", &Options::ball_threshold, "Smallest ball",
                "Polar balls smaller than this are dropped. It should lie above the noise and below the thinnest part "
                "of the shape. 0: chosen automatically and locally.")
        .length("noise", &Options::noise, "Noise",
                "Standard deviation of the noise of the points. The local scale follows from it and from the spacing "
                "of the points. 0: estimated from the points.")
        .number("deep_intersection", &Options::deep_intersection, "Deep intersection",
                "Above 0: neighbouring balls whose intersection is deeper than this (0..1) are put on one side of the "
                "surface, as in the paper. 0: intersections are weighed by the samples around them.")
        .choice("keep_components", &Options::keep_components, {"largest", "all", "automatic"}, "Keep components",
                plugin::tooltips::keep_components)
        .choice("denoise", &Options::denoise, {"automatic", "on", "off"}, "Denoise first",
                "On: the points are projected onto a smooth surface (AMLS) and thinned before the crust is made; "
                "outliers are left out. Off: the power crust of the points as they are. Automatic: on where the noise, "
                "found or given, "
                "is not far below the spacing of the points; isolated points are left out of clean ones, too.")
        .flag("smooth", &Options::smooth, "Smooth",
              "Vertices of a noisy cloud's crust move onto its smooth surface, and where the points show a sharp edge "
              "onto the two faces that meet there; clean clouds are not smoothed. What closes holes of the scan is "
              "drawn taut. The topology stays.")
        .flag("simplify", &Options::simplify, "Simplify",
              "Collapse short edges, to about one vertex per point that the crust was made of: at the point, with "
              "edges along creases, if the cloud is clean. The topology stays.")
        .length("trim_length", &Options::trim_length, "Trim",
                "Instead drop all triangles that are farther than this from every point. 0: do not.")
        .flag("selected_only", &Options::selected_only, "Selected vertices only", plugin::tooltips::selected_only)
        .count("threads", &Options::threads, "Threads", plugin::tooltips::threads);
}

plugin::FilterResult reconstruct(const plugin::InputLayer& layer, const Options& options,
                                 const recon::Progress& progress)
{
    const std::vector<int> used = plugin::vertices_to_use(layer, options.selected_only);
    recon::NoisyPowerCrust crust =
        recon::reconstruct_noisy_power_crust(plugin::pick(layer.points, used), options, progress);

    plugin::FilterResult result;
    result.values = {
        {"points_used", crust.points_used},
        {"spacing", crust.spacing},
        {"noise", crust.noise},
        {"smallest_ball", crust.smallest_ball},
        {"balls_kept", crust.balls_kept},
        {"denoised", crust.denoised},
        {"samples", crust.samples},
        {"completed", crust.completed},
        {"edge_vertices", crust.edge_vertices},
        {"outliers", crust.outliers},
        {"cleanness", crust.cleanness},
        {"violated_votes", crust.violated_votes},
        {"components", crust.components},
        {"euler_characteristic", crust.euler_characteristic},
        {"genus", crust.genus},
        {"boundary_loops", crust.boundary_loops},
    };
    plugin::append_seconds(result, crust.seconds);
    result.warnings = std::move(crust.warnings);
    if (crust.is_convex)
        result.log.push_back(recon::convex_text);

    plugin::NewLayer surface;
    surface.name = "Noisy power crust of " + plugin::name_without_ending(layer);
    surface.mesh = std::move(crust.mesh);
    surface.source = plugin::pick(used, crust.nearest_sample);
    result.new_layers.push_back(std::move(surface));
    return result;
}

struct MedialAxisFilterOptions : recon::PowerShapeOptions
{
    bool selected_only = false;
};

plugin::ParameterTable<MedialAxisFilterOptions> medial_axis_table()
{
    using Options = MedialAxisFilterOptions;
    return plugin::ParameterTable<Options>()
        .choice("side", &Options::side, {"inner", "outer", "both"}, "Side",
                "On which side of the surface. The union whose volume is among the results is that of the inner balls.")
        .length("ball_threshold", &Options::ball_threshold, "Smallest ball",
                "Polar balls smaller than this are dropped. 0: chosen automatically and locally.")
        .number("object_angle", &Options::object_angle, "Object angle",
                "Balls whose points all lie within this angle (degrees, seen from the ball's centre) are dropped: "
                "they come from noise and small bumps. Raise it for a simpler medial axis.")
        .number("redundancy", &Options::redundancy, "Redundancy",
                "Balls that a larger one covers up to this share of their radius (0..1) are dropped. 0: keep all.")
        .choice("denoise", &Options::denoise, {"automatic", "on", "off"}, "Denoise first",
                "On: the points are projected onto a smooth surface (AMLS) and thinned first. Automatic: on from "
                "noise of a hundredth of the points' spacing on.")
        .length("noise", &Options::noise, "Noise", "Standard deviation of the noise of the points. 0: estimated.")
        .flag("selected_only", &Options::selected_only, "Selected vertices only", plugin::tooltips::selected_only)
        .count("threads", &Options::threads, "Threads", plugin::tooltips::threads);
}

plugin::FilterResult make_medial_axis(const plugin::InputLayer& layer, const MedialAxisFilterOptions& options,
                                      const recon::Progress& progress)
{
    const std::vector<int> used = plugin::vertices_to_use(layer, options.selected_only);
    recon::PowerShape shape = recon::compute_power_shape(plugin::pick(layer.points, used), options, progress);

    plugin::FilterResult result;
    result.values = {
        {"points_used", shape.points_used},
        {"denoised", shape.denoised},
        {"spacing", shape.spacing},
        {"noise", shape.noise},
        {"poles", int(shape.centres.size()) - shape.edge_places},
        {"edge_places", shape.edge_places},
        {"triangles", int(shape.triangles.size())},
        {"edges", int(shape.edges.size())},
        {"union_volume", shape.union_volume},
        {"union_area", shape.union_area},
        {"largest_radius", shape.largest_radius},
        {"violated_votes", shape.violated_votes},
    };
    plugin::append_seconds(result, shape.seconds);

    plugin::NewLayer axis;
    axis.name = "Medial axis of " + plugin::name_without_ending(layer);
    axis.mesh.vertices = std::move(shape.centres);
    axis.mesh.triangles = std::move(shape.triangles);
    axis.edges = std::move(shape.edges);
    axis.source = plugin::pick(used, shape.nearest_sample);
    axis.quality = shape.radii;
    axis.radii = std::move(shape.radii);
    result.new_layers.push_back(std::move(axis));
    return result;
}

} // namespace

plugin::PluginSpec plugin::describe_plugin()
{
    FilterSpec filter;
    filter.name = "Surface Reconstruction: Noisy Power Crust";
    filter.python_name = "generate_surface_reconstruction_noisy_power_crust";
    filter.info =
        "Makes a <b>closed surface</b> from points that are <b>noisy</b> and have <b>no normals</b>. The surface is "
        "the boundary between the power cells of polar balls inside and outside of the shape; balls that the noise "
        "has made are dropped, and the samples vote which of the others are inside. The result is a closed, outward "
        "oriented 2-manifold: holes of the scan are closed. The noise, the spacing and the smallest ball are "
        "estimated from the points.<br>Colour and quality are taken from the nearest point.<br><br>See:<br>" +
        std::string(sgp_2005);
    filter.category = Category::remeshing | Category::point_set;
    filter.effects = Effect::makes_layer;
    filter.compute_with(table(), reconstruct);

    FilterSpec medial_axis;
    medial_axis.name = "Medial Axis: Power Shape";
    medial_axis.python_name = "generate_medial_axis_power_shape";
    medial_axis.info =
        "Approximates the <b>medial axis</b> of the shape that the points bound: a layer whose vertices are the "
        "centres of polar balls, with the balls' <b>radii</b> as vertex radius and quality, joined by the edges and "
        "triangles of their regular triangulation. No normals are needed, and the points may be <b>noisy</b>. The "
        "volume of the union of the inner balls is among the results. Sheets are continued to the sharp edges at which "
        "they end, where the radius is 0.<br><br>"
        "See:<br><i>N. Amenta, S. Choi, R. K. Kolluri</i><br><b>\"The Power Crust\"</b><br>"
        "ACM Symposium on Solid Modeling and Applications 2001.<br>" +
        std::string(sgp_2005);
    medial_axis.category = Category::remeshing | Category::point_set;
    medial_axis.effects = Effect::makes_layer;
    medial_axis.compute_with(medial_axis_table(), make_medial_axis);
    return {"Noisy Power Crust", {filter, medial_axis}};
}
