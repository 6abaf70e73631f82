#pragma once

#include "projection.h"
#include "surface.h"

#include <recon/geometry.h>
#include <recon/progress.h>

#include <vector>

namespace recon
{

/// Options of project_to_amls().
struct AmlsProjectionOptions
{
    int max_iterations = 6; ///< Newton steps per point [count], >= 1.
    double tolerance = 0.1; ///< A point has converged when a step is below this [local spacing], > 0, or 1e-5 widths.
    double cut_off = 2.2;   ///< Anchors farther than this do not count [0.85 widths], > 0 and at most the root of 8.
    /// The points are not those of which the surface was made, so they may lie farther from it than noise explains.
    bool foreign_points = false;
    /// Anchors that face another way than the surface at the point must agree with it more closely: errors at bends and
    /// creases are up to 5 % lower, but where sheets crowd, as in the folds of scans, neighbours can settle apart.
    /// Cells whose normals lie across the surface take the side of the anchors around, which fewer samples of thin
    /// parts then contradict; a crust hears of lost walls by those. Without, only cells that noise alone has laid
    /// across a plane look another way, see turn_cells_across().
    bool sharp = true;
    int threads = 0; ///< Threads to use [count], >= 0. 0 = all cores. The result does not depend on it.
};

/// Moves points onto the surface by Newton's method on I (Dey and Sun 2005, eq. 7.11; README.md, step 8), corrected
/// where the residuals of samples tell that it errs. The points may be those of which the surface was made, or others.
/// \throws InvalidInput for a point that is not finite or an option out of range. \throws Cancelled.
AmlsProjection project_to_amls(const Points& points, const AmlsSurface& surface,
                               const AmlsProjectionOptions& options = {}, const Progress& progress = {});

/// The same of points in the unit frame and spatial order, each with a cell near by, without that correction.
AmlsProjection project_in_frame(const AmlsSurface::Data& data, const Points& unit, const std::vector<int>& cell,
                                const AmlsProjectionOptions& options, int threads, const Progress& progress = {});

} // namespace recon
