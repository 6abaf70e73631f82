#pragma once

#include "usable_samples.h"

namespace recon::pn
{

/// Per crease sample that shares its position with one other: where its face lies at the plane of that, 1 above it (the
/// edge is concave) or -1 below (convex); 0 if the samples around do not tell, and for all else.
std::vector<int> sides_of_faces(const UsableSamples& usable);

} // namespace recon::pn
