#pragma once

#include "flat_faces.h"

namespace recon
{

/// Flat faces of a noisy cloud, and the samples on their rims: what noise made of them, denoised in the faces' planes.
struct NoisyFaces
{
    Points rims; ///< What the faces refer to.
    std::vector<FlatFace> faces;
};

/// As find_flat_faces(), from points with noise. Rims are denoised in their planes: across a curve of samples no normal
/// is told from another, so that no surface fitted there can do it. \param points distinct, in spatial order, of unit
/// scale. \param noise standard deviation > 0. \throws Cancelled.
NoisyFaces find_noisy_faces(const Points& points, double noise, int threads, const Progress& progress = {});

} // namespace recon
