#pragma once

#include "filter_spec.h"

#include <host.h> // of interface_2020 or interface_2021

/// The bridge between a FilterSpec and a host's document, compiled once per host.
namespace plugin
{

/// The host's parameter list for the current layer of `document` (which may have none).
RichParameterList rich_parameters(const FilterSpec& spec, const MeshDocument& document);

/// Runs the filter on the current layer and writes what it returns; the new layer, if any, becomes the current one.
/// \throws what the filter throws, or InvalidInput without a layer; the document is then as it was.
FilterResult run_on_document(const FilterSpec& spec, const RichParameterList& parameters, MeshDocument& document,
                             vcg::CallBackPos* callback);

/// MeshLab's mask for the effects of a filter.
int changed_elements(const FilterSpec& spec);

} // namespace plugin
