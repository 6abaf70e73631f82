#pragma once

#include <recon/geometry.h>
#include <recon/labelling/signed_graph.h>
#include <recon/triangulation/power_diagram.h>

#include <vector>

namespace recon
{

/// Makes slices of thin tubes certain where many samples lie on one, as where these are the vertices of a grid: between
/// two rings a tube is one ball, and which ring's samples vote for it rounding decides. Not those of bores: pinholes
/// between walls look the same. \param is_small per ball, whether it may be asked. \param samples in spatial order.
/// \param highest_margin balls at or above it are certain enough. \param margins see measure_margins(); become 1.
void trust_slices_of_tubes(const std::vector<Ball>& balls, const std::vector<Side>& labels,
                           const std::vector<char>& is_small, const Points& samples, double highest_margin,
                           std::vector<double>& margins, int threads);

} // namespace recon
