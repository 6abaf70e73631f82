#pragma once

#include <recon/geometry.h>
#include <recon/labelling/labelled_balls.h>
#include <recon/progress.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace recon
{

/// Sheets with the outside on both sides: scanned from the front, with no ball behind them that could be inside, since
/// the space there is open, or the front of what lies deeper. Nothing is left of them but lace between small balls.
struct LostSheets
{
    std::vector<double> around; ///< Per sample: share of the samples around without an inside [0..1]. Empty: none lost.
    double share = 0;           ///< Of samples most of whose neighbours have no inside [0..1].
    double largest = 0;         ///< Of those of them that hang together the most, as the ground of a cup does [0..1].
};

/// Share of samples in lost sheets above which they get a back if they came out as lace; in one of them, where the
/// labels contradict more votes than is usual, as at the ground of a cup of which only the underside was seen.
inline constexpr double bearable_lost = 0.02;
/// That share of the votes, of labels without normals and with them, and what of it may be left then.
inline constexpr double open_behind = 0.03, open_behind_with_normals = 0.005, clearly_backed = 0.5;

/// What to tell users of lost sheets, to be gone on with, and of those that were given a back. \param share of the
/// samples [0..1].
std::string describe_lost(double share);
std::string describe_backs(double share);

/// \param samples those that `labelled` was made of. \param oriented whether they had normals. \returns none where few
/// samples have no inside, and hardly any of them hang together. \throws Cancelled.
LostSheets find_lost_sheets(const Points& samples, const LabelledBalls& labelled, bool oriented, int threads,
                            const Progress& progress = {});

/// Whether they may be a sheet rather than scattered. Of an open cloud lace may leave only scattered ones without an
/// inside, but then the votes object. \param is_open of a cloud with normals. \param violated share of its votes.
bool may_be_a_sheet(const LostSheets& lost, bool is_open, double violated);

/// Adds the ground of a scene, see find_ground(): there is no ball below it either. \returns whether there is one that
/// faces what stands on it.
bool add_ground(const Points& samples, const Vectors& normals, LostSheets& lost, int threads);

/// Distance from a sheet to its back [spacings]. Slabs of two spacings and more come out whole.
inline constexpr double usual_thickness = 3;

/// Puts samples some spacings behind lost sheets and what borders on them, so that there is a slab to be inside, but
/// none where another sheet is near. \param thickness of the slab [spacings], > 0. \returns how many; they come last.
int back_sheets(const LostSheets& lost, Points& samples, Vectors& normals, int threads,
                double thickness = usual_thickness);

/// Samples with backs behind some sheets, the last of them, and their labels.
struct BackedSheets
{
    Points samples;
    Vectors normals; ///< Empty if the labels were made without.
    LabelledBalls labelled;
    int backs;    ///< [count]
    double share; ///< Of samples in the sheets [0..1].
};

/// Backs behind the lost sheets of a cloud that is whole otherwise, as a wall of a hollow that no view closed, if the
/// crust misses them, and with backs half as much at most, while fewer votes are violated; else none, and none in a
/// scene full of them. \param samples, oriented what `labelled` was made of, and whether with normals. \param
/// list_normals outward normals of all samples, asked for if there are lost sheets. \param lost what find_lost_sheets()
/// said. \throws Cancelled.
std::optional<BackedSheets> label_with_backs(const LostSheets& lost, const Points& samples, bool oriented,
                                             const std::function<Vectors(const Progress&)>& list_normals,
                                             const LabelledBalls& labelled, const BallLabellingOptions& options,
                                             PhaseTimes& times, const Progress& progress = {});

} // namespace recon
