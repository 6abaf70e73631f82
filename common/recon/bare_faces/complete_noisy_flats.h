#pragma once

#include <recon/bare_faces/noisy_faces.h>
#include <recon/geometry.h>

#include <vector>

namespace recon
{

/// What takes the place of samples on the rims of bare flat faces of a noisy cloud.
struct NoisyFlatCompletion
{
    Points points;                 ///< On rims, faces, and the walls that rise straight from rims.
    Vectors normals;               ///< Outward, of unit length, one each.
    std::vector<char> is_replaced; ///< Per denoised sample: the new ones take its place.
};

/// Puts samples on flat faces that carry noisy points on their rims only: on rims, faces and the bare walls between a
/// rim and points straight above or below all along it, walls of bores and edges of plates. \param points distinct, in
/// spatial order, of unit scale. \param noise standard deviation > 0. \param in_slabs what find_noisy_faces() found, in
/// slabs of one width or of several: of a face that is in more than one of them the version with more walls stays.
/// \param leaning as told there, for planes that are found behind those. \param samples denoised points, which tell the
/// outside by their \p normals.
NoisyFlatCompletion complete_noisy_flats(const Points& points, double noise, const std::vector<NoisyFaces>& in_slabs,
                                         Leaning leaning, const Points& samples, const Vectors& normals, int threads);

} // namespace recon
