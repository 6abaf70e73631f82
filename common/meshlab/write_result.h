#pragma once

#include "filter_spec.h"

#include <host.h> // of interface_2020 or interface_2021

/// From what a filter returns to the host's meshes.
namespace plugin
{

/// Checks the whole result, then writes it. New layers come first: should memory run out, they are taken back.
/// \throws std::logic_error for a result that does not fit its input; the document is then as it was.
void write_result(MeshDocument& document, MeshModel& current, const FilterResult& result, const InputLayer& input);

} // namespace plugin
