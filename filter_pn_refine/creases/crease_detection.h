#pragma once

#include "filter_pn_refine/samples/added_samples.h"
#include "filter_pn_refine/samples/usable_samples.h"

#include <recon/progress.h>

#include <vector>

namespace recon::pn
{

/// Crease samples found in a cloud that has none: two points at one position, one with each normal, and three at
/// corners (samples of the result that share a position follow each other). Where near points' normals differ by more
/// than `crease_angle` [radians], the crease runs along the intersection of their tangent planes, or the corner lies
/// where three of them meet; creases are sampled about as densely as the cloud. Only lines along which both faces end
/// sharply (ends_sharply()) in enough places are creases: clouds of smooth shapes and noisy clouds get none.
/// None where all samples that show it are frozen. In spatial order. \param spacing as from find_spacing().
AddedSamples detect_creases(const UsableSamples& usable, const std::vector<float>& spacing, double crease_angle,
                            int threads, const Progress& progress = {});

} // namespace recon::pn
