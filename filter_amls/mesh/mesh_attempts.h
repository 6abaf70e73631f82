#pragma once

#include "filter_amls/surface/surface.h"
#include "label_points.h"
#include "reconstruct_amls.h"

#include <recon/crust/crust.h>
#include <recon/geometry.h>
#include <recon/progress.h>

#include <optional>
#include <vector>

namespace recon
{

/// A mesh of the points denoised as if they had a given noise.
struct MeshAttempt
{
    AmlsSurface surface;
    LabelledSamples found;
    TriangleMesh mesh = {};               ///< In input units.
    std::vector<char> is_on_surface = {}; ///< Per vertex.
    DroppedBodies dropped = {};
    bool is_opened = false; ///< Whether lids were taken off what it had closed.
};

/// \param noise 0 = estimate. \param earlier attempt, if there was one. \throws AlgorithmFailure if nothing is inside,
/// or all points are isolated. \throws Cancelled.
MeshAttempt attempt_mesh(const Points& points, const AmlsReconstructionOptions& options, double noise,
                         const MeshAttempt* earlier, PhaseTimes& times, const Progress& progress);

/// The mesh in the frame of its samples.
TriangleMesh crust_of(const MeshAttempt& attempt);

/// Whether bare lids seem to close what walls hold that were taken for noise: votes object, or points lie beside the
/// surface as no noise does.
bool seems_filled(const Points& points, const MeshAttempt& attempt, int threads);

/// What attempts with other noise than was told brought.
struct OtherNoise
{
    std::optional<MeshAttempt> attempt = {};
    bool may_lack_walls = false;    ///< Whether the first seems_filled(), and no walls were found.
    bool is_between_sheets = false; ///< Whether it has more noise, and the first wove.
};

/// More noise, where the first attempt weaves between sheets, see weaving.h. Less, where it seems_filled(), as walls of
/// one to two spacings read as noise: an attempt without lids with half of it, a quarter, an eighth, if there is one;
/// else that with an eighth, or the one that tells that none would do, with open lids, if the points object to lids and
/// not to these. \param first attempt, whose noise was estimated. \throws Cancelled.
OtherNoise look_with_other_noise(const Points& points, const AmlsReconstructionOptions& options,
                                 const MeshAttempt& first, PhaseTimes& times, const Progress& progress);

/// Puts samples on faces that carry none, see bare_faces.h, if points object to the mesh without and not to that.
/// \param surface of the points with the noise that was told or estimated, whatever the attempt assumes. \returns
/// whether it did.
bool complete_bare_faces(MeshAttempt& attempt, const AmlsSurface& surface, const Points& points,
                         const AmlsReconstructionOptions& options, PhaseTimes& times, const Progress& progress);

} // namespace recon
