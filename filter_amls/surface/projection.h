#pragma once

#include <recon/geometry.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace recon
{

enum class ProjectionStatus : std::uint8_t
{
    converged,
    fell_back,     ///< Newton's method left the neighbourhood; the point lies on the local plane instead.
    not_converged, ///< The last position within bounds.
    kept,          ///< Not moved: the surface rounds off a detail here, such as an edge, in which other samples agree.
    too_far,       ///< Not moved: not one of the samples, and too far from them to tell to which place it belongs.
    outlier        ///< Not moved: alone off the surface.
};

/// Whether a point with this status was moved.
inline bool is_moved(ProjectionStatus status)
{
    return status <= ProjectionStatus::not_converged;
}

/// Projected points with what happened to each.
struct AmlsProjection
{
    Points points;
    Vectors normals; ///< Of unit length, outward: gradient of I. Of outliers that of the nearest surface.
    std::vector<ProjectionStatus> status;
    std::vector<double> widths;            ///< h at the point [length].
    std::vector<double> spacings;          ///< Distance of neighbouring input points there [length].
    std::vector<std::uint8_t> iterations;  ///< Newton steps [count].
    std::vector<std::uint16_t> neighbours; ///< Anchors that count in the last step [count].

    int count(ProjectionStatus wanted) const { return int(std::count(status.begin(), status.end(), wanted)); }
};

} // namespace recon
