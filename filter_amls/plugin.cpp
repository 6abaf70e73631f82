#include "plugin_filters.h"

#include <recon/noise/rounding.h>

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
    if (report.lattice_step > 0)
    {
        std::ostringstream rounded;
        rounded << "The points lie on a lattice, as voxels or rounded coordinates do, in steps of "
                << report.lattice_step << ": the noise is taken to be no less than " << report.lattice_error << ".";
        result.log.push_back(rounded.str());
    }
    if (!report.seen_from.empty())
    {
        std::ostringstream places;
        for (const Point& place : report.seen_from)
            places << (places.tellp() > 0 ? ", (" : "(") << place.x() << ", " << place.y() << ", " << place.z() << ")";
        const bool is_one = report.seen_from.size() == 1;
        result.log.push_back("The points are what " +
                             (is_one ? "one camera or scanner" : std::to_string(report.seen_from.size()) + " scans") +
                             " saw from " + places.str() + ": normals face " + (is_one ? "it." : "these places."));
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
