#include "mesh_attempts.h"

#include "filter_amls/sides/crust_of_points.h"
#include "filter_amls/surface/sample_surface.h"
#include "filter_amls/surface/surface_data.h"
#include "smooth_mesh.h"

#include <recon/bare_faces/bare_faces.h>
#include <recon/crust/lids.h>
#include <recon/crust/weaving.h>
#include <recon/errors.h>
#include <recon/mesh/mismatch.h>
#include <recon/parallel.h>
#include <recon/scan/viewpoint.h>
#include <recon/search/nearest_samples.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace recon
{
namespace
{

/// What a mesh is compared with: copies would leave points without a spacing, and the order of the input chance.
Points list_distinct(const Points& points, const AmlsSurface& surface)
{
    return points_at(surface.data().spatial.order, points);
}

bool has_lids(const MeshAttempt& attempt, const TriangleMesh& crust, int threads)
{
    return measure_bare_area(attempt.found.samples, crust, threads) > bare_lid;
}

Mismatch measure_mismatch(const Points& points, const MeshAttempt& attempt, int threads)
{
    return measure_mismatch(attempt.found.frame.to_unit(list_distinct(points, attempt.surface)), crust_of(attempt),
                            threads);
}

/// Per vertex of the mesh: whether the nearest sample was put on a bare face. Empty if none was.
std::vector<char> list_completed(const MeshAttempt& attempt, int threads)
{
    const LabelledSamples& found = attempt.found;
    std::vector<char> result;
    if (found.completed == 0)
        return result;
    const int first = int(found.samples.size()) - found.completed;
    const Points vertices = found.frame.to_unit(attempt.mesh.vertices);
    for (const int sample : find_nearest_samples(vertices, found.samples, threads).sample)
        result.push_back(sample >= first);
    return result;
}

/// The crust of the attempt's labels, on its surface but for faces that were completed.
void make_mesh(MeshAttempt& attempt, const Points& points, const AmlsReconstructionOptions& options, PhaseTimes& times,
               const Progress& progress)
{
    const LabelledSamples& found = attempt.found;
    times.begin("crust");
    CrustOptions crust;
    crust.keep_components = options.keep_components;
    crust.simplify = options.simplify;
    crust.target_vertices = int(found.samples.size());
    crust.interpolated = &found.samples;
    crust.threads = resolve_threads(options.threads);
    crust.find_viewpoints = [&] { return find_viewpoints(points, crust.threads, progress.part(0, 0)).in(found.frame); };
    attempt.mesh = make_crust(found.labelled, crust, progress.part(0, 0.5, "crust"), &attempt.dropped);
    found.frame.from_unit_in_place(attempt.mesh.vertices);
    attempt.is_on_surface.assign(attempt.mesh.vertices.size(), 0);
    if (!found.is_exact)
    {
        times.begin("smooth");
        const std::vector<char> are_completed = list_completed(attempt, crust.threads);
        attempt.is_on_surface = smooth_mesh(attempt.mesh, attempt.surface, options.threads,
                                            progress.part(0.5, 1, "projection of the mesh"), are_completed);
    }
}

/// Opens all lids. \param mismatch of the best attempt so far. \returns whether that is clearly better.
bool open_lids(MeshAttempt& attempt, const Points& points, const AmlsReconstructionOptions& options, double mismatch,
               PhaseTimes& times, const Progress& progress)
{
    LabelledSamples& found = attempt.found;
    if (found.labelled.violated_votes <= objecting_votes || found.normals.empty())
        return false;
    const int threads = resolve_threads(options.threads);
    std::optional<LabelledBalls> opened =
        label_with_open_lids(found.samples, found.normals, found.labelled, options_for_labels(threads), times,
                             progress.part(0, 0.7, "open lids"));
    if (!opened)
        return false;
    found.labelled = std::move(*opened);
    attempt.is_opened = true;
    make_mesh(attempt, points, options, times, progress.part(0.7, 1));
    return measure_mismatch(points, attempt, threads).sum() < clearly_better * mismatch;
}

} // namespace

TriangleMesh crust_of(const MeshAttempt& attempt)
{
    return {attempt.found.frame.to_unit(attempt.mesh.vertices), attempt.mesh.triangles, {}};
}

MeshAttempt attempt_mesh(const Points& points, const AmlsReconstructionOptions& options, double noise,
                         const MeshAttempt* earlier, PhaseTimes& times, const Progress& progress)
{
    times.begin("surface");
    AmlsOptions surface_options;
    surface_options.rho_e = options.rho_e;
    surface_options.noise = noise;
    surface_options.threads = options.threads;
    surface_options.for_crust = true;
    AmlsSurface surface = build_amls_surface(points, surface_options, progress.part(0, 0.4, "AMLS surface"), {},
                                             earlier ? &earlier->surface : nullptr);
    BallLabellingOptions labelling = options_for_labels(resolve_threads(options.threads));
    // Where samples disputed that they share balls, those of the next attempt would, too.
    if (earlier && !earlier->found.labelled.is_shared)
        labelling.sharing = BallSharing::none;
    LabelledSamples labelled =
        label_points(points, surface, noise == 0, labelling, times, progress.part(0.4, 0.8, "labels"));
    MeshAttempt attempt{std::move(surface), std::move(labelled)};
    make_mesh(attempt, points, options, times, progress.part(0.8, 1));
    return attempt;
}

bool seems_filled(const Points& points, const MeshAttempt& attempt, int threads)
{
    const LabelledSamples& found = attempt.found;
    const double noise = attempt.surface.report().noise / found.frame.scale();
    if (found.is_exact || noise < least_noise_of_walls * found.labelled.spacing)
        return false;
    const TriangleMesh crust = crust_of(attempt);
    if (!has_lids(attempt, crust, threads))
        return false;
    if (found.labelled.violated_votes > objecting_votes)
        return true;
    if (attempt.surface.report().has_only_lattice_noise())
        return false;
    const Points claimed = found.frame.to_unit(points_at(found.claimed, points));
    return !measure_noise_misfit(claimed, crust, noise, threads).is_noise();
}

namespace
{

struct MeshedWalls
{
    std::optional<MeshAttempt> found = {};
    bool has_none = false; ///< Whether there are none to find.
};

MeshedWalls look_for_meshed_walls(const Points& points, const AmlsReconstructionOptions& options,
                                  const MeshAttempt& first, PhaseTimes& times, const Progress& progress)
{
    const int threads = resolve_threads(options.threads);
    const double noise = first.surface.report().noise;
    const Mismatch mismatch = measure_mismatch(points, first, threads);
    const PointsAgainst before{mismatch.missed_points, first.found.labelled.violated_votes};
    std::optional<MeshAttempt> last;
    bool has_none = false;
    for (int i = 1; i <= halvings; ++i)
    {
        last.reset();
        try
        {
            last = attempt_mesh(points, options, std::ldexp(noise, -i), &first, times,
                                progress.part(0.9 * (i - 1) / halvings, 0.9 * i / halvings, "less noise"));
        }
        catch (const AlgorithmFailure&) // nothing is inside
        {
            continue;
        }
        const TriangleMesh crust = crust_of(*last);
        if (!has_lids(*last, crust, threads))
            return {std::move(last)};
        const double missed =
            measure_missed_points(last->found.frame.to_unit(list_distinct(points, last->surface)), crust, threads);
        has_none = finds_no_walls(before, {missed, last->found.labelled.violated_votes});
        if (has_none)
            break;
        if (missed > barely_less * before.missed)
            i = std::max(i, halvings - 1);
    }
    if (last && open_lids(*last, points, options, mismatch.sum(), times, progress.part(0.9, 1)))
        return {std::move(last)};
    return {{}, has_none};
}

struct MeshBetweenSheets
{
    MeshAttempt attempt;
    bool has_lids; ///< What lids close may be hollows that were filled: of the first, too, unless that looked open.
};

std::optional<MeshBetweenSheets> look_between_sheets(const Points& points, const AmlsReconstructionOptions& options,
                                                     const MeshAttempt& first, PhaseTimes& times,
                                                     const Progress& progress)
{
    const LabelledSamples& found = first.found;
    const AmlsSurfaceReport& report = first.surface.report();
    const bool is_settled = found.is_exact || found.is_settled || found.completed > 0;
    if (is_settled ||
        !may_weave(found.labelled.violated_votes, report.noise / found.frame.scale() / found.labelled.spacing))
        return {};
    const int threads = resolve_threads(options.threads);
    const Points claimed = points_at(found.claimed, points);
    Points samples = found.samples;
    found.frame.from_unit_in_place(samples);
    const auto describe = [&](const MeshAttempt& attempt)
    { return describe_woven(attempt.found.labelled.violated_votes, attempt.mesh, samples, threads); };
    const Woven woven = describe(first);
    if (report.open && woven.bare_area > bare_if_open)
        return {};
    constexpr int most = int(std::size(reach_over_sheets));
    for (int i = 0; i < most; ++i)
    {
        try
        {
            const double noise = reach_over_sheets[i] * report.noise;
            MeshAttempt wide = attempt_mesh(points, options, noise, &first, times,
                                            progress.part(double(i) / most, (i + 1.0) / most, "more noise"));
            if (wide.surface.report().open || wide.found.backs > 0)
                continue;
            const Woven with_more = describe(wide);
            if (lies_between_sheets(woven, with_more, measure_noise_misfit(claimed, wide.mesh, noise, threads)))
                return MeshBetweenSheets{std::move(wide), !report.open && with_more.bare_area > bare_lid};
        }
        catch (const AlgorithmFailure&) // nothing is inside
        {
        }
    }
    return {};
}

} // namespace

OtherNoise look_with_other_noise(const Points& points, const AmlsReconstructionOptions& options,
                                 const MeshAttempt& first, PhaseTimes& times, const Progress& progress)
{
    std::optional<MeshBetweenSheets> between =
        look_between_sheets(points, options, first, times, progress.part(0, 0.4));
    const bool is_settled = between && !between->has_lids;
    if (!is_settled && seems_filled(points, first, resolve_threads(options.threads)))
    {
        MeshedWalls walls = look_for_meshed_walls(points, options, first, times, progress.part(0.4, 1));
        if (walls.found)
            return {std::move(walls.found)};
        if (!between)
            return {{}, !walls.has_none};
    }
    if (between)
        return {std::move(between->attempt), false, true};
    return {};
}

bool complete_bare_faces(MeshAttempt& attempt, const AmlsSurface& surface, const Points& points,
                         const AmlsReconstructionOptions& options, PhaseTimes& times, const Progress& progress)
{
    LabelledSamples& found = attempt.found;
    const int threads = resolve_threads(options.threads);
    std::vector<int> claimed;
    const auto list_samples = [&]
    {
        const bool is_sheet = is_open_sheet(surface);
        if (!found.is_exact)
        {
            SurfaceSamples sampled = sample_amls_surface(points, surface, threads, progress.part(0, 0.3, "samples"));
            claimed = std::move(sampled.claimed);
            return SamplesOfFaces{{found.frame.to_unit(sampled.samples.points), std::move(sampled.samples.normals)},
                                  is_sheet};
        }
        // What was added came last.
        Points samples(found.samples.begin(), found.samples.end() - found.completed - found.backs);
        Points in_place = samples;
        found.frame.from_unit_in_place(in_place);
        Vectors normals = list_surface_normals(in_place, surface, threads, progress.part(0, 0.3, "normals"));
        return SamplesOfFaces{{std::move(samples), std::move(normals)}, is_sheet};
    };
    std::optional<LabelledBareFaces> faces =
        label_with_bare_faces(surface.data().spatial.order.size(), found.labelled.violated_votes, list_samples,
                              label_within(options_for_labels(threads), times, progress.part(0.4, 0.8, "polar balls")),
                              times, threads, progress.part(0.3, 0.4));
    if (!faces)
        return false;
    attempt.surface = surface;
    found.claimed = std::move(claimed);
    found.samples = std::move(faces->samples);
    found.normals = std::move(faces->normals);
    found.labelled = std::move(faces->labelled);
    found.completed = faces->added;
    found.backs = 0;
    found.lost_sheets = 0;
    attempt.is_opened = false;
    make_mesh(attempt, points, options, times, progress.part(0.8, 1));
    return true;
}

} // namespace recon
