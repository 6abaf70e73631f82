#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>

#include <vector>

namespace recon
{

/// Unit normals with a consistent sign, outward where there is an outside, and what the Delaunay balls tell besides.
struct Orientation
{
    Vectors normals;
    Points poles;                ///< Centres of large balls along the normals: points near the medial axis.
    double contradicted = 0;     ///< Share of the weight of the constraints that the labels violate [0..1].
    bool open = false;           ///< Much of what would close the surface spans gaps: a sheet, which has no inside.
    std::vector<char> is_closed; ///< Per point: of a smaller piece of an open cloud that is closed by itself, as a ball
                                 ///< beside a floor, and faces outward whatever the rest does.
};

/// Chooses the sign of each normal from the Delaunay balls of the points (README.md, step 6). Balls of neighbouring
/// cells that intersect deeply lie on one side, the two poles of a point on opposite ones; of these constraints as much
/// weight as can be found is kept (label_balls()). \pre points are distinct, of unit scale, thin (not a slab of noise),
/// at least one; normals of unit length. \param spacing distance of neighbouring points [length], per point. \throws
/// Cancelled.
Orientation orient_normals(const Points& points, const Vectors& normals, const std::vector<double>& spacing,
                           int threads, const Progress& progress = {});

} // namespace recon
