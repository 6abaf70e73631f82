#pragma once

#include <recon/bare_faces/flat_faces.h>

#include <array>
#include <vector>

namespace recon
{

/// A closed curve of the rim of a face.
struct RimCurve
{
    std::vector<int> places;               ///< In FlatFace::rim, ascending.
    std::vector<std::array<int, 2>> edges; ///< Of places in `places`.
};

/// What bounds a face's triangles; rim samples that none of these edges ends at are on no curve.
std::vector<RimCurve> list_rim_curves(const FlatFace& face);

} // namespace recon
