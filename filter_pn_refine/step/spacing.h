#pragma once

#include "filter_pn_refine/samples/nearest_table.h"

#include <recon/geometry.h>

#include <vector>

namespace recon::pn
{

/// Usual distance between samples around each one: the root of the area per sample among the nearest, averaged over
/// them. Single clusters and empty places hardly change it, so that it tells an empty place from a sparse cloud.
std::vector<float> find_spacing(const OrientedSamples& samples, const NearestTable& nearest, int threads);

} // namespace recon::pn
