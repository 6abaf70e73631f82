#include "sample_surface.h"

#include "filter_amls/cells/thin.h"
#include "project.h"
#include "surface_data.h"

#include <recon/parallel.h>

namespace recon
{
namespace
{

constexpr double pi = 3.14159265358979323846;

AmlsProjection project_as_samples(const Points& points, const AmlsSurface& surface, int threads,
                                  const Progress& progress)
{
    AmlsProjectionOptions options;
    options.threads = threads;
    options.sharp = false; // where sheets crowd, samples that settle apart make handles
    return project_to_amls(points, surface, options, progress);
}

} // namespace

SurfaceSamples sample_amls_surface(const Points& points, const AmlsSurface& surface, int threads,
                                   const Progress& progress)
{
    threads = resolve_threads(threads);
    const AmlsProjection projected = project_as_samples(points, surface, threads, progress.part(0, 0.8, "projection"));
    const AmlsSurface::Data& data = surface.data();
    SurfaceSamples result;
    // In spatial order, so that the choice does not depend on the order of the input.
    for (const int i : data.spatial.order)
    {
        if (projected.status[i] == ProjectionStatus::outlier)
        {
            ++result.outliers;
            continue;
        }
        result.claimed.push_back(i);
    }
    const std::size_t n = result.claimed.size();
    OrientedSamples kept{Points(n), Vectors(n)};
    std::vector<double> radii(n), expected(n);
    parallel_for(
        n, threads, {},
        [&](std::size_t k)
        {
            const int i = result.claimed[k];
            kept.points[k] = projected.points[i];
            kept.normals[k] = projected.normals[i];
            const int point = data.spatial.representative[std::size_t(i)];
            radii[k] = 0.4 * data.frame.scale() * data.sampling_widths[data.cells.cell_of_point[point]];
            const double spacings = radii[k] / projected.spacings[i];
            expected[k] = pi * spacings * spacings;
        },
        4096);
    for (const int i : thin_to_poisson_disks(kept.points, kept.normals, radii, expected, threads))
    {
        result.samples.points.push_back(kept.points[i]);
        result.samples.normals.push_back(kept.normals[i]);
    }
    progress.report(1);
    return result;
}

Vectors list_surface_normals(const Points& points, const AmlsSurface& surface, int threads, const Progress& progress)
{
    return project_as_samples(points, surface, threads, progress).normals;
}

} // namespace recon
