#pragma once

#include "filter_spec.h"

#include <host.h> // of interface_2020 or interface_2021

#include <string>
#include <vector>

/// From the host's meshes to what a filter sees.
namespace plugin
{

constexpr char radius_attribute[] = "radius"; // the name that MeshLab's own filters use

using Radii = CMeshO::PerVertexAttributeHandle<Scalarm>;

/// The attribute of that name, if there is one.
const vcg::PointerToAttribute* find_radius_attribute(const CMeshO& mesh);
/// The same as radii; nothing, if there is none or it holds something else, of a user's. Test with vcglib's
/// IsValidHandle().
Radii find_radii(CMeshO& mesh);

recon::Point to_point(const Point3m& p);

/// The vertices in the order in which the filter sees them.
std::vector<CVertexO*> live_vertices(CMeshO& mesh);

InputLayer read_layer(MeshModel& model);

/// The layer of that name among the others, moved from its own coordinates to those of `current`.
/// \throws InvalidInput if there is not exactly one, or its transform cannot be inverted.
InputLayer read_other_layer(MeshDocument& document, const MeshModel& current, const std::string& name);

} // namespace plugin
