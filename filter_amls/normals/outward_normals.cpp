#include "outward_normals.h"

#include "filter_amls/mesh/label_points.h"
#include "filter_amls/mesh/mesh_attempts.h"
#include "filter_amls/sides/crust_normals.h"
#include "filter_amls/sides/crust_of_points.h"
#include "filter_amls/sides/face_cameras.h"
#include "filter_amls/surface/project.h"
#include "normals_near_crust.h"

#include <recon/errors.h>
#include <recon/mesh/convex_surface.h>
#include <recon/parallel.h>
#include <recon/scan/viewpoint.h>

#include <limits>
#include <optional>

namespace recon
{
namespace
{

/// Share of violated votes above which the crust's sides are not trusted: up to 0.045 on coarse exact clouds they are
/// better than those of the AMLS surface, at 0.08 worse; 0.016 and 0.057 on noisy ones.
constexpr double trusted_votes = 0.05;
/// How far from the samples a crust may be to have a say where scanners stand within [spacings]: it leaves out things
/// whose back nobody saw, and closes their shadows by faces of any direction. Of thin parts that it leaves out else it
/// often knows the side.
constexpr double farthest_of_scans = 2;

/// A crust through the points or, if these are noisy, through samples of their surface.
struct TrustedCrust
{
    LabelledSamples found;
    CrustNormals crust;
    double noise_between = 0; ///< Assumed where it lies between sheets, see weaving.h; else 0 [length].
};

/// Of a closed cloud; none of an open one, whose crust has lids, for which its sides are chosen, unless it is one of
/// lost tubes or bare flat faces, which look open.
std::optional<LabelledSamples> label(const Points& points, const AmlsSurface& surface, bool is_noise_given, int threads,
                                     const Progress& progress)
{
    PhaseTimes times;
    const BallLabellingOptions options = options_for_labels(threads);
    if (!surface.report().open)
        return label_points(points, surface, !is_noise_given, options, times, progress);
    if (is_noise_given)
        return {};
    std::optional<LabelledSamples> tubes = label_only_tubes(points, surface, options, times, progress.part(0, 0.3));
    return tubes ? std::move(tubes) : label_only_flats(points, surface, options, times, progress.part(0.3, 1));
}

CrustNormals list_crust_normals(const LabelledSamples& found, int threads, const Progress& progress)
{
    return list_crust_normals(found.samples, found.labelled, threads, progress);
}

/// With less noise, where that shows walls that were taken for noise, or with more, where the surface weaves.
/// \returns that more noise, else 0.
double try_other_noise(const Points& points, const AmlsSurface& surface, LabelledSamples& found, CrustNormals& crust,
                       int threads, const Progress& progress)
{
    MeshAttempt attempt{surface, std::move(found), crust.crust};
    attempt.found.frame.from_unit_in_place(attempt.mesh.vertices);
    AmlsReconstructionOptions options;
    options.threads = threads;
    PhaseTimes times;
    OtherNoise other = look_with_other_noise(points, options, attempt, times, progress.part(0, 0.9));
    found = std::move(other.attempt ? other.attempt->found : attempt.found);
    if (other.attempt)
        crust = list_crust_normals(found, threads, progress.part(0.9, 1));
    progress.report(1);
    return other.is_between_sheets ? other.attempt->surface.report().noise : 0;
}

/// None if it is not to be trusted.
std::optional<TrustedCrust> find_trusted_crust(const Points& points, const AmlsSurface& surface, bool is_noise_given,
                                               int threads, const Progress& progress)
{
    std::optional<LabelledSamples> found;
    CrustNormals crust;
    double noise_between = 0;
    try
    {
        found = label(points, surface, is_noise_given, threads, progress.part(0, 0.4));
        if (!found)
            return {};
        crust = list_crust_normals(*found, threads, progress.part(0.4, 0.5, "crust"));
        if (!is_noise_given)
            noise_between = try_other_noise(points, surface, *found, crust, threads, progress.part(0.5, 1));
    }
    catch (const AlgorithmFailure&) // nothing is inside
    {
        return {};
    }
    if (found->labelled.violated_votes > trusted_votes)
        return {};
    return TrustedCrust{std::move(*found), std::move(crust), noise_between};
}

/// The surface's, and those of the crust where that knows better.
OutwardNormals find_normals(const Points& points, AmlsOptions options, const Progress& progress)
{
    options.for_labels = true;
    OutwardNormals result;
    AmlsProjection projected;
    const int threads = resolve_threads(options.threads);
    const auto project = [&](const AmlsSurface& surface, const Progress& part)
    {
        AmlsProjectionOptions projection;
        projection.threads = options.threads;
        projected = project_to_amls(points, surface, projection, part);
        result.surface = surface.report();
        result.normals = projected.normals;
    };
    const AmlsSurface surface = build_amls_surface(points, options, progress.part(0, 0.5, "AMLS surface"));
    project(surface, progress.part(0.5, 0.6, "AMLS projection"));
    if (!result.surface.seen_from.empty())
        return result;
    // A room is closed around its scanners, and its walls face these, as all that anything sees does.
    const Viewpoints within = result.surface.open
                                  ? Viewpoints()
                                  : find_viewpoints(points, threads, progress.part(0.6, 0.64, "Places of scanners"));
    if (const auto trusted = find_trusted_crust(points, surface, options.noise > 0, threads, progress.part(0.64, 0.9)))
    {
        const auto& [found, crust, noise_between] = *trusted;
        if (noise_between > 0)
        {
            AmlsOptions wider = options;
            wider.noise = noise_between;
            project(build_amls_surface(points, wider, progress.part(0.9, 0.94, "AMLS surface"), {}, &surface),
                    progress.part(0.94, 0.95, "AMLS projection"));
            result.lies_between_sheets = true;
        }
        result.is_exact = found.is_exact;
        result.surface.open = false; // as it looked
        const double farthest = within.empty() ? std::numeric_limits<double>::infinity() : farthest_of_scans;
        const Progress last = progress.part(0.95, 1, "normals");
        result.of_crust =
            found.is_exact
                ? take_normals_of_exact_crust(found, crust, points, projected, farthest, threads, result.normals, last)
                : take_normals_beside_crust(found, crust, points, farthest, threads, result.normals, last);
    }
    result.surface.seen_from = within.places();
    if (!within.empty())
        face_cameras(within, points, result.normals, threads);
    return result;
}

/// Few points that all lie on their convex hull face away from what is within: long faces, as a cone's, look like
/// sheets.
void face_out_of_hull(const Points& points, OutwardNormals& found)
{
    const std::optional<ConvexSurface> hull = find_convex_surface(points);
    if (!hull)
        return;
    Point within = Point::Zero();
    for (const Point& p : hull->mesh.vertices)
        within += p / double(hull->mesh.vertices.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        if (found.normals[i].dot(points[i] - within) < 0)
            found.normals[i] = -found.normals[i];
}

} // namespace

OutwardNormals find_outward_normals(const Points& points, const AmlsOptions& options, const Progress& progress)
{
    const ThreadTeam team;
    OutwardNormals found = find_normals(points, options, progress);
    if (found.surface.seen_from.empty() && options.noise == 0)
        face_out_of_hull(points, found);
    return found;
}

} // namespace recon
