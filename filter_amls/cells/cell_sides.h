#pragma once

#include "cells.h"
#include "filter_amls/fits/fit.h"

#include <recon/search/block_search.h>

#include <vector>

namespace recon
{

/// Turns the normals of cells to those of the anchors that pass them nearby, where these agree (README.md, step 6). At
/// a rim, and in the tails of the noise, a cell's own normal lies across the surface, so that its sign tells no side.
/// Between two sheets the anchors disagree and it stays. \param search of the anchors' positions. \param normals of the
/// cells: unit length, outward.
void follow_anchors(const Cells& cells, const std::vector<Anchor>& anchors, const BlockSearch& search, Vectors& normals,
                    int threads);

} // namespace recon
