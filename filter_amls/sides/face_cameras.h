#pragma once

#include <recon/geometry.h>
#include <recon/scan/viewpoint.h>

namespace recon
{

/// Turns normals towards the cameras that saw their points. Neighbours that agree turn together: of grazing rays, and
/// where normals are bad, as between the lines of a scanner, the angle with the ray tells no side. Exact minimum of
/// the cosines of normals that face away, and of the agreements that are cut. \param cameras their places. \param
/// normals of unit length, one per point. The result does not depend on the number of threads.
void face_cameras(const Viewpoints& cameras, const Points& points, Vectors& normals, int threads);

} // namespace recon
