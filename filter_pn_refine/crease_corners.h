#pragma once

#include "crease_places.h"

#include <vector>

namespace recon::pn
{

/// Adds corners at which edges end, where the samples of one face are too far from those of another to show it. Places
/// on edges very near to them are given up.
void close_corners(const Faces& faces, std::vector<CreasePlace>& places);

} // namespace recon::pn
