#pragma once

#include <recon/geometry.h>
#include <recon/triangulation/triangulation.h>

#include <vector>

namespace recon
{

/// Turns closed pieces outward, by the volume that they enclose: in an open cloud the inside of a sheet reaches out to
/// the box, and what stands there would be a hollow. Pieces with half of all area and more are none (the walls of a
/// street), nor are hollows of others. \param delaunay of the points and others beyond them. \param spacing distance of
/// neighbouring points [length], per point. \param normals of unit length, here and below. \returns per point whether
/// it is of such a piece.
std::vector<char> turn_closed_pieces(const Triangulation& delaunay, const Points& points,
                                     const std::vector<double>& spacing, Vectors& normals);

/// Turns what is open over so that it encloses a positive volume, or, if it is too flat to tell, so that closed pieces
/// stand before it. Of a closed cloud a hardly negative volume says nothing: that of a thin ring is less than the error
/// of the areas.
void turn_outward(const Points& points, const std::vector<double>& spacing, bool is_open,
                  const std::vector<char>& is_closed, Vectors& normals);

/// Where stays[i] is 0.
void turn_over(Vectors& normals, const std::vector<char>& stays);

} // namespace recon
