#include "plugin_filters.h"

#include <sstream>

void recon::plugin_filters::add_report(const AmlsSurfaceReport& report, plugin::FilterResult& result)
{
    result.values.emplace_back("noise", report.noise);
    result.values.emplace_back("spacing", report.spacing);
    result.values.emplace_back("width", report.width);
    result.values.emplace_back("rho_e", report.rho_e);
    result.values.emplace_back("cells", report.cells);
    result.values.emplace_back("anchors", report.anchors);
    result.values.emplace_back("open", report.open);
    plugin::append_seconds(result, report.seconds);
    if (report.seen_from)
    {
        std::ostringstream place;
        place << report.seen_from->x() << ", " << report.seen_from->y() << ", " << report.seen_from->z();
        result.log.push_back("The points are what one camera or scanner saw from (" + place.str() +
                             "): normals face it.");
    }
    else if (report.open)
        result.log.push_back(
            "The points are an open sheet without inside and outside: normals are consistent across it, "
            "but which side they point to has no meaning. Those of a level one, as a terrain, point up (z).");
}

plugin::PluginSpec plugin::describe_plugin()
{
    using namespace recon::plugin_filters;
    return {"AMLS", {describe_normals(), describe_feature_size(), describe_projection(), describe_reconstruction()}};
}
