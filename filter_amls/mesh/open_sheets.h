#pragma once

#include <recon/crust/back_sheets.h>
#include <recon/geometry.h>
#include <recon/labelling/labelled_balls.h>
#include <recon/progress.h>

#include <optional>

namespace recon
{

/// Share of samples that the crust of noisy ones misses where a sheet is lost, however deep the rest: 0.19 of a roll,
/// 0.005 of a scanned statue, whose back would take as long as all else. As much may be missed of an exact slab: where
/// a scanner's lines are far from each other its back comes between them, behind thinned samples it does not.
inline constexpr double much_missed = 0.02;

/// Whether votes object to labels without normals, and their crust misses samples: below an open sheet, as a terrain or
/// a part of a cylinder, is no ball that could be inside, or one here and there.
bool may_lack_sheets(const Points& samples, const LabelledBalls& labelled, int threads);

/// Labels of an open sheet with a back behind all of it, so that it becomes a slab; backs behind parts alone leave
/// flaps where slab and lid meet. Bodies beside it that are closed by themselves get none. \param closed labels with
/// normals, by a lid: votes must object to them, and the lid lie near to most of the sheet, or much of it be missed.
/// None else, and if the slab lacks parts, too, or has parts without a sample in front, as where a body became a
/// hollow, or more handles, nor of more than a million samples. \param normals one per sample, of one side. \param
/// is_seen whether the places are known that the sheet was scanned from, so that it has no other side, and the slab
/// may lack more. \throws Cancelled.
std::optional<BackedSheets> back_open_sheet(const Points& samples, const Vectors& normals, const LabelledBalls& closed,
                                            bool is_seen, const BallLabellingOptions& options, PhaseTimes& times,
                                            const Progress& progress = {});

/// Labels of the exact points of an open sheet with its normals: closed by a lid, or, where that lies near, touches the
/// sheet so that it has handles or misses any of it, by such a back. None if both lack parts.
std::optional<BackedSheets> label_open_sheet(const Points& samples, const Vectors& normals,
                                             const BallLabellingOptions& options, PhaseTimes& times,
                                             const Progress& progress = {});

} // namespace recon
