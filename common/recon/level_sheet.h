#pragma once

#include <recon/geometry.h>

namespace recon
{

/// Whether an open sheet is a terrain whose normals point down: a level sheet, at most a quarter as high (z) as it is
/// long and wide, normals on the whole along z. Nothing else tells above from below there.
/// \param normals per point, times the area for which it stands.
bool is_upside_down(const Points& points, const Vectors& normals);

} // namespace recon
