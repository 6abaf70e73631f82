#pragma once

#include "crust_normals.h"

#include <recon/geometry.h>
#include <recon/labelling/labelled_balls.h>
#include <recon/progress.h>

#include <optional>

namespace recon
{

/// For labels of points as they are, or of denoised samples, through which the crust goes.
BallLabellingOptions options_for_labels(int threads);

/// The crust through points as they are, made when it is first asked for. Surfaces of the same points share it,
/// whatever noise they assume, and so do labels of exact points.
class CrustOfPoints
{
public:
    struct Made
    {
        LabelledBalls labelled; ///< Without normals, by options_for_labels().
        CrustNormals crust;
    };

    /// Null where the points are too noisy for such a crust, or where it contradicts them. \param points distinct, in
    /// the unit frame and spatial order; the same in every call. \throws Cancelled.
    const Made* find(const Points& points, int threads, const Progress& progress = {});
    /// Null also if nobody has asked for it.
    const Made* made() const { return made_ ? &*made_ : nullptr; }

private:
    bool is_asked_ = false;
    std::optional<Made> made_;
};

} // namespace recon
