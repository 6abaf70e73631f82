#pragma once

#include "crease_places.h"

#include <vector>

namespace recon::pn
{

/// Adds corners where two edges of a face meet and the samples of its neighbours are too far apart to show it. Places
/// on edges very near to them are given up.
void close_corners(const Faces& faces, std::vector<CreasePlace>& places);

} // namespace recon::pn
