#pragma once

#include "flat_faces.h"

#include <recon/geometry.h>
#include <recon/progress.h>

namespace recon
{

/// Samples put on flat faces that had none but on their rims.
struct FlatCompletion
{
    Points points;   ///< The new samples.
    Vectors normals; ///< Of unit length, one each; empty if the samples had none.
    int faces = 0;   ///< Flat faces completed [count].
};

/// Finds flat faces without samples (find_flat_faces()) and fills them, densely near their rims and by 0.15 per unit of
/// distance less densely away from them. \param normals outward, one per sample, or empty. \throws Cancelled.
FlatCompletion complete_flats(const Points& samples, const Vectors& normals, const FlatFaceOptions& options = {},
                              const Progress& progress = {});

} // namespace recon
