#pragma once

#include <recon/geometry.h>
#include <recon/scan/viewpoint.h>

#include <functional>

namespace recon
{

/// Which components of a crust are kept.
enum class KeepComponents
{
    largest,  ///< Only the one that encloses the largest volume.
    all,      ///< Stray shells too.
    automatic ///< The largest, those that hold a twentieth of the triangles of the one that has most, or more, and
              ///< those that are full: volume / area of 1.5 spacings, as of a ball of 250 samples, or 0.4 if they hold
              ///< 100 triangles as densely as the rest, as a board of which both sides were seen; as densely in angle,
              ///< as seen from the scanner, if its place is known. What labels get wrong at thin walls had up to 0.041
              ///< of the triangles and 0.97 in trials, and would stay if it had 100. Hollows count as bodies, but must
              ///< be full.
};

/// Bodies that were left out; hollows do not count.
struct DroppedBodies
{
    int count = 0;
    double volume = 0;  ///< In volumes of the largest.
    double samples = 0; ///< Share of all, told from the triangles [0..1].
};

/// Removes the other components, and the vertices that only they use. \param spacing root of the area per sample, at
/// least; that of a sparser component is told from its triangles. \param find_viewpoints places of scanners in the
/// frame of the mesh, asked for if bodies would be left out for their thickness or density alone.
DroppedBodies drop_components(TriangleMesh& mesh, KeepComponents kept, double spacing,
                              const std::function<Viewpoints()>& find_viewpoints = {});

} // namespace recon
