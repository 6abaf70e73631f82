#pragma once

#include <recon/geometry.h>

#include <optional>
#include <vector>

namespace recon
{

/// A table or a floor, and what stands on it.
struct Ground
{
    Point origin;
    Vector normal;            ///< Of unit length, on the whole that of its points.
    std::vector<int> members; ///< Points that lie in it, ascending.
    bool faces_things = true; ///< Whether these stand where the normal points.
};

/// Unit normals, each times the area for which its point stands. \param spacing per point [length].
Vectors times_area(Vectors normals, const std::vector<double>& spacing);

/// The ground of an open sheet: a plane that holds a quarter of the area or more, while most of what does not lie in it
/// is on one side, and within its rim on all sides. Of an open box or can the walls are at the rim of each plane.
/// \param normals per point, times the area for which it stands.
std::optional<Ground> find_ground(const Points& points, const Vectors& normals);

/// Whether an open sheet is a terrain whose normals point down: a level sheet, at most a quarter as high (z) as it is
/// long and wide, normals on the whole along z; or a ground that turns its back to what stands on it; or a room without
/// a ceiling or a street, whose level floor of a quarter of the area faces down, all else above.
/// \param normals per point, times the area for which it stands.
bool is_upside_down(const Points& points, const Vectors& normals);

} // namespace recon
