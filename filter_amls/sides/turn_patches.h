#pragma once

#include <recon/geometry.h>
#include <recon/triangulation/triangulation.h>

#include <vector>

namespace recon
{

/// Turns patches over where a seam runs through a smooth surface: on either side of it normals are opposite, though
/// nothing bends there. Balls find the hollow side of a sheet inside, so the two ends of an S have opposite ones. A
/// patch is what hangs together by neighbours that lie in each other's tangent plane and agree; one turns if such
/// seams are half of its bounds, over a ground nearly all, so not what meets others at creases, thin walls or by a
/// bridge. The largest of those that seams join stays. \param delaunay of the points and others beyond them. \param
/// spacing distance of neighbouring points [length], per point. \param has_ground whether things stand on a ground,
/// which meet it at creases. \param normals of unit length. \returns the share of points turned [0..1].
double turn_patches(const Triangulation& delaunay, const Points& points, const std::vector<double>& spacing,
                    bool has_ground, Vectors& normals, int threads);

} // namespace recon
