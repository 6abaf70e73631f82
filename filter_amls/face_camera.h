#pragma once

#include <recon/geometry.h>

namespace recon
{

/// Turns normals towards the camera that saw their points. Neighbours that agree turn together: of grazing rays, and
/// where normals are bad, as between the lines of a scanner, the angle with the ray tells no side. Exact minimum of
/// the cosines of normals that face away, and of the agreements that are cut. \param camera its place. \param normals
/// of unit length, one per point. The result does not depend on the number of threads.
void face_camera(const Point& camera, const Points& points, Vectors& normals, int threads);

} // namespace recon
