#pragma once

#include <recon/bare_faces/flat_faces.h>
#include <recon/geometry.h>
#include <recon/progress.h>

namespace recon
{

/// Samples put on flat faces that had none but on their rims.
struct FlatCompletion
{
    Points points;         ///< The new samples, on faces and on walls between them.
    int faces = 0;         ///< Flat faces completed [count].
    Points with_all_walls; ///< Instead, less certain: on walls that end at other rims, too. Empty if there are none.
};

/// Finds flat faces without samples (find_flat_faces()) and fills them, densely near their rims and by 0.15 per unit of
/// distance less densely away from them. \throws Cancelled.
FlatCompletion complete_flats(const Points& samples, const FlatFaceOptions& options = {},
                              const Progress& progress = {});

/// New samples on one face. \param rims what the face refers to. \param present samples near which none is needed.
Points fill_face(const FlatFace& face, const Points& rims, const Points& present, int threads);

} // namespace recon
