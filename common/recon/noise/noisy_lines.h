#pragma once

#include <recon/geometry.h>
#include <recon/search/block_search.h>

#include <vector>

namespace recon
{

/// Radii of neighbourhoods that reach over several lines [length], one per seed, where points lie on lines and noise
/// moves them along one plane through theirs only; 0 elsewhere. So lie the readings of a scanner of few beams: noise is
/// along the rays, those of a beam are a cone, and its readings lie in that as samples of a surface lie in it, without
/// any noise, so that a neighbourhood within one line tells neither noise nor surface. None if hardly any of some two
/// hundred points spread over the cloud lie like that. \param search of the points, which are distinct.
std::vector<double> find_noisy_lines(const Points& points, const BlockSearch& search, const Points& seeds, int threads);

/// Whether any are found.
bool has_noisy_lines(const Points& points, const BlockSearch& search, int threads);

} // namespace recon
