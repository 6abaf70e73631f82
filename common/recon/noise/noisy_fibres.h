#pragma once

#include <recon/geometry.h>
#include <recon/search/block_search.h>

#include <vector>

namespace recon
{

/// Fibres in a neighbourhood that tells their noise [count].
constexpr double fibres_in_reach = 16;

/// Radii of neighbourhoods that hold so many fibres [length], one per seed, where points lie on fibres; 0 elsewhere.
/// Fibres are short straight lines beside each other: copies of a sample that noise has moved along its normal, or what
/// a camera saw in one pixel of many frames. They need not be exact if they follow the surface's normal. A few of them
/// are as well described by a quadric through them, which has no noise, as by the surface that they cross. None if few
/// of some two hundred points spread over the cloud lie on fibres, or nearly as many seem to along the surface. \param
/// search of the points, which are distinct.
std::vector<double> find_noisy_fibres(const Points& points, const BlockSearch& search, const Points& seeds,
                                      int threads);

/// Whether any are found.
bool has_noisy_fibres(const Points& points, const BlockSearch& search, int threads);

} // namespace recon
