#pragma once

#include <recon/signed_labelling.h>
#include <recon/triangulation.h>

#include <vector>

namespace recon
{

/// Turns over inner islands and outer voids that hold fewer balls than `share` of the largest inner component.
/// Hidden balls and the root are left alone. \returns the number of balls turned.
int absorb_islands(const Triangulation& regular, const std::vector<char>& is_root, double share, std::vector<Side>& labels);

/// Takes out of `doubtful` the inner balls without which a large part of the inside, of at least `share` times the balls of the
/// largest, would come off: those of a chain to it, the weakest of which has the highest margin.
void spare_bridges(const Triangulation& regular, const std::vector<Side>& labels, const std::vector<double>& margins, double share,
                   std::vector<int>& doubtful);

/// Cuts handles and fills tunnels that hang on doubtful small balls: a ball on the interface with margin below
/// `highest_margin` and radius below `largest_radius` of its own takes the other side if its neighbours on its own side fall
/// into several pieces, more than those of the other side, and stay connected without it. Lowest margin first.
/// \returns the number of balls turned.
struct HandleRepairOptions
{
    double highest_margin = 0.6; ///< At 0.8 thin tubes of clean clouds are cut through.
    int rounds = 5;
};
int cut_handles(const Triangulation& regular, const std::vector<char>& is_root, const std::vector<char>& is_small,
                const std::vector<double>& margins, const HandleRepairOptions& options, std::vector<Side>& labels);

} // namespace recon
