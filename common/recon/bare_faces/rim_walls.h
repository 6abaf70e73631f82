#pragma once

#include <recon/bare_faces/flat_faces.h>
#include <recon/bare_faces/wall_samples.h>
#include <recon/geometry.h>
#include <recon/progress.h>
#include <recon/search/neighbours.h>

namespace recon
{

/// Samples on walls that rise straight from any rim to another in a parallel plane: cylinders between chamfers,
/// counterbores, pockets with fillets. A rim sample bounds two surfaces: faces in its planes; strips to the next rims
/// where these sample the surface one after another, as of lathed shapes; and walls, the lowest first. No wall begins
/// where samples go on straight before it.
/// \param samples what the faces refer to, and `search` with them. \param walls without any yet.
/// \throws Cancelled.
Points fill_rim_walls(const FlatFaces& faces, const Points& samples, const NeighbourSearch& search, WallSamples walls,
                      int threads, const Progress& progress);

} // namespace recon
