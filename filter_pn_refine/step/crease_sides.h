#pragma once

#include "face_sector.h"
#include "filter_pn_refine/samples/usable_samples.h"

#include <cstdint>
#include <vector>

namespace recon::pn
{

/// Per crease sample what WorkPoint::Flag says of where its face lies; 0 if the samples around do not tell, and for all
/// else. At an edge: above the plane of the other face (the edge is concave) or below it (convex). At a corner of three
/// faces: in which sector of its plane, between the edges that the other two leave to it.
std::vector<std::uint32_t> sides_of_faces(const UsableSamples& usable);

/// The same as directions. \param sides from sides_of_faces().
std::vector<FaceSector> sectors_of_faces(const UsableSamples& usable, const std::vector<std::uint32_t>& sides);

} // namespace recon::pn
