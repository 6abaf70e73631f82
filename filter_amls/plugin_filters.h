#pragma once

#include "filter_amls/surface/surface.h"

#include <meshlab/filter_spec.h>

/// The filters of this plugin, each described in a file of its own, and what they share.
namespace recon::plugin_filters
{

plugin::FilterSpec describe_normals();
plugin::FilterSpec describe_feature_size();
plugin::FilterSpec describe_projection();
plugin::FilterSpec describe_reconstruction();

inline constexpr char citation[] = "See:<br><i>T. K. Dey, J. Sun</i><br>"
                                   "<b>\"An Adaptive MLS Surface for Reconstruction with Guarantees\"</b><br>"
                                   "Eurographics Symposium on Geometry Processing 2005.<br>";

/// Appends what was found while building the surface to the result values, and to the log what the user should know.
void add_report(const AmlsSurfaceReport& report, plugin::FilterResult& result);

} // namespace recon::plugin_filters
