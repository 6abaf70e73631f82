#pragma once

#include <recon/labelling/signed_graph.h>
#include <recon/triangulation/triangulation.h>

#include <vector>

namespace recon
{

/// Radius below which a ball may be noise [local scales].
constexpr double small_below = 2;

/// Margin below which a small ball is doubtful; at 0.8 thin tubes of clean clouds are cut through.
constexpr double doubtful_below = 0.6;

/// Turns over inner islands and outer voids that hold fewer balls than `share` of the largest inner component, with
/// those that coincide and without, unless they are bodies or hollows: hold 30 balls or more, a large one among them.
/// Hidden balls and the root are left alone. \param weight per ball how many it counts for with those that coincide
/// with it: a coarse ball beside a fine one is none of either. \param is_large whether a ball is larger than noise
/// makes them. `threads` >= 1 here and below. \returns the number of balls turned.
int absorb_islands(const Triangulation& regular, const std::vector<char>& is_root, const std::vector<int>& weight,
                   const std::vector<char>& is_large, double share, std::vector<Side>& labels, int threads = 1);

/// Takes out of `doubtful` the inner balls without which a large part of the inside, of at least `share` times the
/// balls of the largest, would come off: those of a chain to it, the weakest of which has the highest margin.
void spare_bridges(const Triangulation& regular, const std::vector<Side>& labels, const std::vector<double>& margins,
                   double share, std::vector<int>& doubtful, int threads = 1);

/// Cuts handles and fills tunnels that hang on one doubtful small ball: on the interface it takes the other side if its
/// neighbours on its own side fall into several pieces, more than those of the other side, and stay connected without
/// it. Lowest margin first, in five rounds at most. \returns the number of balls turned.
int cut_handles(const Triangulation& regular, const std::vector<char>& is_root, const std::vector<char>& is_small,
                const std::vector<double>& margins, std::vector<Side>& labels, int threads = 1);

} // namespace recon
