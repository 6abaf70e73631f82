#pragma once

#include "filter_amls/paper/feature_size.h"
#include "surface.h"

namespace recon
{

/// Feature sizes and the poles they were measured to, in input units.
struct LocalFeatureSize
{
    std::vector<double> at_query; ///< Distance to the nearest pole [length].
    Points poles;
};

/// Local feature size at points on or near an AMLS surface: the distance to the nearest pole of its anchors, which are
/// thinned and almost free of noise, so that their Delaunay balls approximate the medial balls.
/// \throws AlgorithmFailure if there is no pole. \throws InvalidInput for a bad option. \throws Cancelled.
LocalFeatureSize find_local_feature_size(const Points& queries, const AmlsSurface& surface,
                                         const FeatureSizeOptions& options = {}, const Progress& progress = {});

} // namespace recon
