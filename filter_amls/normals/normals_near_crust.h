#pragma once

#include "filter_amls/mesh/label_points.h"
#include "filter_amls/sides/crust_normals.h"
#include "filter_amls/surface/project.h"

#include <recon/geometry.h>
#include <recon/progress.h>

namespace recon
{

/// Puts normals of a crust in the place of those of the AMLS surface, where it knows better which way points face. Of a
/// crust through exact points those of its vertices: it has edges and spikes that the surface rounds. But it is rough
/// where these have noise of a hundredth of their spacing, so it has a say only where the surface passes by the point
/// or those around. \param surface of the points, projected. \param normals of the points; some are
/// replaced. \param farthest samples farther from the crust are left out by it, so it has no say of points nearest to
/// them [mean distance of the six nearest samples]; may be infinite. \returns how many. \throws Cancelled.
int take_normals_of_exact_crust(const LabelledSamples& found, const CrustNormals& crust, const Points& points,
                                const AmlsProjection& surface, double farthest, int threads, Vectors& normals,
                                const Progress& progress = {});

/// The same of a crust through samples of the surface: those of its nearest place. The nearest sample of a point may
/// lie beyond an edge, and at thin parts on the other side.
int take_normals_beside_crust(const LabelledSamples& found, const CrustNormals& crust, const Points& points,
                              double farthest, int threads, Vectors& normals, const Progress& progress = {});

} // namespace recon
