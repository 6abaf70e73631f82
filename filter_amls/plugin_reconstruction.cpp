#include "plugin_filters.h"

#include "filter_amls/mesh/reconstruct_amls.h"

#include <meshlab/shared_parameters.h>
#include <recon/mesh/convex_surface.h>

namespace
{

using recon::plugin_filters::citation;

struct ReconstructionFilterOptions : recon::AmlsReconstructionOptions
{
    bool selected_only = false;
};

plugin::ParameterTable<ReconstructionFilterOptions> reconstruction_table()
{
    using Options = ReconstructionFilterOptions;
    return plugin::ParameterTable<Options>()
        .flag("open_holes", &Options::open_holes, "Leave holes open", plugin::tooltips::open_holes)
        .number("rho_e", &Options::rho_e, "Width (rho_e)",
                "Width of the Gaussian weights in local feature sizes (the paper uses 0.75). 0: automatic, from noise, "
                "spacing and curvature.")
        .length("noise", &Options::noise, "Noise", "Standard deviation of the noise of the points. 0: estimated.")
        .choice("keep_components", &Options::keep_components, {"largest", "all", "automatic"}, "Keep components",
                plugin::tooltips::keep_components)
        .flag("simplify", &Options::simplify, "Simplify",
              "Collapse short edges, to about one vertex per sample. The topology stays.")
        .flag("selected_only", &Options::selected_only, "Selected vertices only", plugin::tooltips::selected_only)
        .count("threads", &Options::threads, "Threads", plugin::tooltips::threads);
}

plugin::FilterResult reconstruct(const plugin::InputLayer& layer, const ReconstructionFilterOptions& options,
                                 const recon::Progress& progress)
{
    const std::vector<int> used = plugin::vertices_to_use(layer, options.selected_only);
    recon::AmlsReconstruction found = recon::reconstruct_amls(plugin::pick(layer.points, used), options, progress);

    plugin::FilterResult result;
    result.values = {
        {"noise", found.surface.noise},
        {"spacing", found.surface.spacing},
        {"rho_e", found.surface.rho_e},
        {"samples", found.samples},
        {"completed", found.completed},
        {"outliers", found.outliers},
        {"vertices_on_surface", found.vertices_on_surface},
        {"components", found.components},
        {"euler_characteristic", found.euler_characteristic},
        {"genus", found.genus},
        {"boundary_loops", found.boundary_loops},
        {"open", found.surface.open},
        {"violated_votes", found.violated_votes},
    };
    plugin::append_seconds(result, found.seconds);
    result.warnings = std::move(found.warnings);
    if (found.is_convex)
        result.log.push_back(recon::convex_text);

    plugin::NewLayer surface;
    surface.name = "AMLS surface of " + plugin::name_without_ending(layer);
    surface.mesh = std::move(found.mesh);
    surface.source = plugin::pick(used, found.nearest_sample);
    result.new_layers.push_back(std::move(surface));
    return result;
}

} // namespace

plugin::FilterSpec recon::plugin_filters::describe_reconstruction()
{
    plugin::FilterSpec spec;
    spec.name = "Surface Reconstruction: AMLS";
    spec.python_name = "generate_surface_reconstruction_amls";
    spec.info =
        std::string(
            "Makes a <b>smooth closed surface</b> from points that are <b>noisy</b> and have <b>no "
            "normals</b>: the points are moved onto their AMLS surface and thinned, a power crust of "
            "them gives the triangles, and its vertices are put on the AMLS surface. Points without "
            "noise stay where they are. Holes of the scan are closed, or stay open on request. Nothing needs to be "
            "tuned.<br>Colour and quality are taken from the nearest point.<br><br>") +
        citation;
    spec.category = plugin::Category::remeshing | plugin::Category::point_set;
    spec.effects = plugin::Effect::makes_layer;
    spec.compute_with(reconstruction_table(), reconstruct);
    return spec;
}
