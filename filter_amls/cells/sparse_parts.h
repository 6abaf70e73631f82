#pragma once

#include "cells.h"

namespace recon
{

/// What a cell is that finds hardly any others within its width.
struct LonelyCell
{
    bool belongs = false; ///< To a part that is sparser than those beside it; else it is scattered through space.
    double spacing = 0; ///< Distance of neighbouring samples of the sheet to which it belongs, 0 if not known [length].
};

/// Whether most of what is around one of the points lies near one plane or sphere through it: of those scattered
/// through space one in 50. \param slack how far off a plane besides what grows with the distance [length].
bool is_on_sheet(const Points& points, const BlockSearch& search, int point, double slack);

/// Tells sparse parts of a surface, as beside dense ones, from outliers. To one belong: cells most of whose neighbours,
/// as many of a sparse part as of a dense one, lie near one plane or sphere through them; those close to such cells;
/// and those that lie closer together than the others would if they were spread evenly over the box of the rest.
/// \param lonely cells. \param search of the cells' means.
std::vector<LonelyCell> find_sparse_parts(const Cells& cells, const BlockSearch& search, const std::vector<int>& lonely,
                                          int threads);

} // namespace recon
