#pragma once

#include <recon/bare_faces/flat_faces.h>
#include <recon/bare_faces/noisy_planes.h>
#include <recon/bare_faces/slab_spots.h>

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
NoisyFaces find_noisy_faces(const Points& points, double noise, Leaning leaning, int threads,
                            const Progress& progress = {});

/// The same in planes that are known. \throws Cancelled.
NoisyFaces find_noisy_faces_on(const Points& points, const std::vector<NoisyPlane>& planes, double noise,
                               Leaning leaning, int threads);

/// Adds the faces of `more` and their rims to `all`.
void append(NoisyFaces&& more, NoisyFaces& all);

} // namespace recon
