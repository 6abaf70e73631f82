#include "sharpen_normals.h"

#include "filter_pn_refine/creases/crease_detection.h"
#include "filter_pn_refine/samples/usable_samples.h"
#include "filter_pn_refine/step/spacing.h"
#include "prepare_input.h"

#include <recon/parallel.h>

#include <algorithm>
#include <cmath>

namespace recon::pn
{
namespace
{

constexpr int passes = 15;
constexpr int around = 13;       ///< Samples averaged, itself among them.
constexpr double on_face = 0.03; ///< Planes of a face pass within this of its samples [spacings].

Vectors average_on_faces(const UsableSamples& usable, const std::vector<float>& spacing, int threads)
{
    const Points& points = usable.samples.points;
    const Vectors& normals = usable.samples.normals;
    Vectors averaged(points.size());
    parallel_for(points.size(), threads, {},
                 [&](std::size_t i)
                 {
                     const int* const near = usable.nearest.of(i);
                     const int count = std::min(around, usable.nearest.count);
                     const double farthest = (points[std::size_t(near[count - 1])] - points[i]).squaredNorm(),
                                  width = on_face * double(spacing[i]);
                     Vector sum = normals[i];
                     for (int m = 1; m < count; ++m)
                     {
                         const auto j = std::size_t(near[m]);
                         const Vector d = points[j] - points[i];
                         const double height = d.dot(normals[j]) / width;
                         if (normals[j].dot(normals[i]) > 0)
                             sum += std::exp(-height * height - d.squaredNorm() / farthest) * normals[j];
                     }
                     averaged[i] = sum.normalized();
                 });
    return averaged;
}

} // namespace

Vectors sharpen_normals(const OrientedSamples& samples, const PnRefineOptions& options, const Progress& progress)
{
    const double crease_angle = options.crease_angle * radians;
    const int threads = resolve_threads(options.threads);
    UsableSamples usable;
    const UnitFrame frame(samples.points);
    choose_usable_samples(samples, {}, frame, crease_angle, threads, progress.part(0, 0.3, "normals"), usable);
    if (usable.input.empty())
        return samples.normals;
    const std::vector<float> spacing = find_spacing(usable.samples, usable.nearest, threads);
    for (int pass = 0; pass < passes; ++pass)
    {
        progress.part(0.3, 0.8, "normals").report(double(pass) / passes);
        usable.samples.normals = average_on_faces(usable, spacing, threads);
    }
    if (detect_creases(usable, spacing, crease_angle, threads, progress.part(0.8, 1, "normals")).samples.points.empty())
        return samples.normals;
    Vectors normals = samples.normals;
    for (std::size_t i = 0; i < normals.size(); ++i)
    {
        // Duplicates follow, else the two normals at one place might look like a crease.
        const Point p = frame.to_unit(samples.points[i]);
        const auto nearest = std::size_t(usable.search->nearest(p));
        if (usable.samples.points[nearest] == p)
            normals[i] = usable.samples.normals[nearest];
    }
    return normals;
}

} // namespace recon::pn
