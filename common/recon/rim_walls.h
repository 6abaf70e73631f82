#pragma once

#include <recon/flat_faces.h>
#include <recon/geometry.h>

namespace recon
{

/// Samples on walls that rise straight from any rim to another in a parallel plane: cylinders between chamfers,
/// counterbores, pockets with fillets. A rim sample bounds two surfaces: faces in its planes; strips to the next rims
/// where these sample the surface one after another, as of lathed shapes; and walls, the lowest first. No wall begins
/// where samples go on straight before it.
/// \param samples what the faces refer to. \param present near these no sample is put.
Points fill_rim_walls(const FlatFaces& faces, const Points& samples, const Points& present);

} // namespace recon
