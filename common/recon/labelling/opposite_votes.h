#pragma once

#include <recon/labelling/signed_graph.h>
#include <recon/progress.h>
#include <recon/search/block_search.h>
#include <recon/triangulation/polar_balls.h>

#include <vector>

namespace recon
{

/// What the samples say: each votes that its two sides differ. A sample whose poles are both kept votes with -cos of
/// the angle between them; of the others, every one of an even stride looks for two opposite balls among the poles of
/// its 16 to 128 nearest samples, across a slab of noise that is thicker than the spacing. Needs no normals. \param
/// samples with the box corners last. \param search over the samples without the corners. \returns edges between balls
/// with weights <= 0.
std::vector<SignedEdge> list_opposite_votes(const Points& samples, const PolarBalls& balls, const BlockSearch& search,
                                            int threads, const Progress& progress = {});

} // namespace recon
