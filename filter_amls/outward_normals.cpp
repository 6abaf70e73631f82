#include "outward_normals.h"

#include "crust_normals.h"
#include "label_points.h"
#include "project.h"

#include <recon/block_search.h>
#include <recon/depth_image.h>
#include <recon/errors.h>
#include <recon/parallel.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace recon
{
namespace
{

/// Share of violated votes above which the crust's sides are not trusted: up to 0.045 on coarse exact clouds they are
/// better than those of the AMLS surface, at 0.08 worse.
constexpr double trusted_votes = 0.05;
/// The surface's normal stays if it is within this of the crust's [radians], and more where the crust is rough
/// [radians per spacing].
constexpr double agreeing = 0.1;
constexpr double agreeing_roughness = 5;

/// A crust through exact points.
struct ExactCrust
{
    Vectors normals; ///< One per point, zero if it has none.
    double least_roughness = 0;
};

/// None if the points are not exact, or the crust is not to be trusted.
std::optional<ExactCrust> find_exact_crust(const Points& points, const AmlsSurface& surface, int threads,
                                           const Progress& progress)
{
    PhaseTimes times;
    std::optional<LabelledSamples> found;
    Vectors normals;
    try
    {
        // An open cloud's crust has lids, and its sides are chosen for them. But lost tubes look open.
        const auto label = surface.report().open ? label_only_tubes : label_only_exact_points;
        found = label(points, surface, options_for_labels(threads), times, progress.part(0, 0.8));
        if (!found || found->labelled.violated_votes > trusted_votes)
            return {};
        normals = list_crust_normals(found->samples, found->labelled, threads, progress.part(0.8, 1, "crust")).normals;
    }
    catch (const AlgorithmFailure&) // nothing is inside
    {
        return {};
    }
    const BlockSearch search(found->samples);
    ExactCrust crust{Vectors(points.size()), found->least_roughness};
    parallel_for(
        points.size(), threads, {},
        [&](std::size_t i)
        { crust.normals[i] = normals[std::size_t(search.nearest(found->frame.to_unit(points[i])))]; },
        1024);
    return crust;
}

/// The surface's, and those of the crust where that knows better.
OutwardNormals find_normals(const Points& points, const AmlsOptions& options, const Progress& progress)
{
    const AmlsSurface surface = build_amls_surface(points, options, progress.part(0, 0.5, "AMLS surface"));
    AmlsProjectionOptions projection;
    projection.threads = options.threads;
    OutwardNormals result;
    result.surface = surface.report();
    result.normals = project_to_amls(points, surface, projection, progress.part(0.5, 0.6, "AMLS projection")).normals;
    if (options.noise > 0 || result.surface.seen_from)
        return result;
    const auto crust = find_exact_crust(points, surface, resolve_threads(options.threads), progress.part(0.6, 1));
    if (!crust)
        return result;
    result.is_exact = true;
    const double least_cosine = std::cos(std::min(agreeing + agreeing_roughness * crust->least_roughness, 1.0));
    for (std::size_t i = 0; i < points.size(); ++i)
    {
        const Vector& normal = crust->normals[i];
        if (normal.squaredNorm() > 0 && normal.dot(result.normals[i]) < least_cosine)
            result.normals[i] = normal;
    }
    return result;
}

/// A room is closed around its scanner, and its walls face that, as all that anything sees does.
void face_scanner_within(const Points& points, OutwardNormals& found)
{
    if (found.surface.open)
        return;
    const std::optional<DepthCamera> scanner = find_depth_camera(points);
    if (!scanner)
        return;
    found.surface.seen_from = scanner->place;
    std::ptrdiff_t balance = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
        balance += found.normals[i].dot(scanner->place - points[i]) > 0 ? 1 : -1;
    if (balance < 0)
        for (Vector& normal : found.normals)
            normal = -normal;
}

} // namespace

OutwardNormals find_outward_normals(const Points& points, const AmlsOptions& options, const Progress& progress)
{
    const ThreadTeam team;
    OutwardNormals found = find_normals(points, options, progress);
    face_scanner_within(points, found);
    return found;
}

} // namespace recon
