#include "local_feature_size.h"

#include "surface_data.h"

#include <recon/errors.h>
#include <recon/parallel.h>

namespace recon
{

LocalFeatureSize find_local_feature_size(const Points& queries, const AmlsSurface& surface,
                                         const FeatureSizeOptions& options, const Progress& progress)
{
    const AmlsSurface::Data& data = surface.data();
    Vectors normals;
    for (const Anchor& a : data.anchors)
        normals.push_back(a.normal);
    const PolarCells polar = find_polar_cells(data.anchor_positions, normals, resolve_threads(options.threads),
                                              progress.part(0, 0.8, "Delaunay triangulation"));
    LocalFeatureSize result;
    result.poles =
        select_poles(polar.delaunay, data.anchor_positions, normals, data.anchor_spacing, polar.outer, polar.inner);
    if (result.poles.empty())
        throw AlgorithmFailure(
            "No Delaunay ball approximates a medial ball: the cloud is flat, too sparse, or its noise is "
            "as thick as the shape.");
    data.frame.from_unit_in_place(result.poles);
    result.at_query = measure_feature_size(queries, result.poles, options, progress.part(0.8, 1, "Feature size"));
    return result;
}

} // namespace recon
