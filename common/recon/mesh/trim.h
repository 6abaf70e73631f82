#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>
#include <recon/scan/viewpoint.h>

#include <vector>

namespace recon
{

/// Drops triangles of which a corner, the middle of a side or the centre is farther than `length` from every point.
/// What is left has manifold rims: of triangles that meet at a vertex only, the larger fan stays, and islands of a few
/// triangles go. Parts face the viewpoints, if any are known, else level sheets face up (level_sheet.h).
/// \param mesh closed. \param points at least one. \returns for
/// each vertex that is left its former index. \throws Cancelled.
std::vector<int> trim_by_length(TriangleMesh& mesh, const Points& points, double length, int threads = 1,
                                const Progress& progress = {}, const Viewpoints& viewpoints = {});

/// Opens a crust over holes and open ends of the scan, with manifold rims as above. Bare is what lies farther than two
/// spacings from every sample; bare parts that reach three spacings are dropped, lesser gaps stay closed. Spacing of a
/// place: that of all but the sparsest tenth of the samples around it, so that a hole is one beside dense samples only;
/// a sample's is that of the lines of its scan, if these are farther apart and the viewpoints known (line_spacing.h).
/// \param mesh closed. \param samples in its units. \param backs the last samples, which nobody scanned [count]; what
/// they carry is bare, but rims of a few sides that it leaves within a sheet are closed. If all is bare nothing is
/// dropped. \returns as above.
std::vector<int> open_holes(TriangleMesh& mesh, const Points& samples, int backs, int threads = 1,
                            const Progress& progress = {}, const Viewpoints& viewpoints = {});

} // namespace recon
