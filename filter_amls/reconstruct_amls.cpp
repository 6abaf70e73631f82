#include "reconstruct_amls.h"

#include "label_points.h"
#include "smooth_mesh.h"
#include "surface_data.h"

#include <recon/back_sheets.h>
#include <recon/crust_mesh.h>
#include <recon/depth_image.h>
#include <recon/errors.h>
#include <recon/lids.h>
#include <recon/mismatch.h>
#include <recon/neighbours.h>
#include <recon/parallel.h>
#include <recon/taut_closing.h>
#include <recon/trim.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace recon
{
namespace
{

/// \param is_on_surface loses the vertices that go.
void open_amls_holes(TriangleMesh& mesh, const LabelledSamples& found, const Points& points,
                     std::vector<char>& is_on_surface, int threads, const Progress& progress)
{
    Points samples = found.samples;
    found.frame.from_unit_in_place(samples);
    std::vector<char> left;
    for (const int former : open_holes(mesh, samples, found.backs, threads, progress, find_depth_camera(points)))
        left.push_back(is_on_surface[former]);
    is_on_surface = std::move(left);
}

/// A mesh of the points denoised as if they had a given noise.
struct Attempt
{
    AmlsSurface surface;
    LabelledSamples found;
    TriangleMesh mesh = {};
    std::vector<char> is_on_surface = {}; ///< Per vertex.
    DroppedBodies dropped = {};
    bool is_opened = false; ///< Whether lids were taken off what it had closed.
};

/// In the frame of its samples.
TriangleMesh crust_of(const Attempt& attempt)
{
    return {attempt.found.frame.to_unit(attempt.mesh.vertices), attempt.mesh.triangles, {}};
}

/// Over holes of the scan; vertices that move are on the surface no more.
void draw_closings_taut(Attempt& attempt, int threads)
{
    TriangleMesh taut = crust_of(attempt);
    const Points before = taut.vertices;
    if (draw_bare_faces_taut(taut, attempt.found.samples, threads) == 0)
        return;
    for (std::size_t v = 0; v < before.size(); ++v)
        if (taut.vertices[v] != before[v])
        {
            attempt.is_on_surface[v] = 0;
            attempt.mesh.vertices[v] = attempt.found.frame.from_unit(taut.vertices[v]);
        }
}

/// What a mesh is compared with: copies would leave points without a spacing, and the order of the input chance.
Points list_distinct(const Points& points, const AmlsSurface& surface)
{
    return points_at(surface.data().spatial.order, points);
}

bool has_lids(const Attempt& attempt, const TriangleMesh& crust, int threads)
{
    return measure_bare_area(attempt.found.samples, crust, threads) > bare_lid;
}

/// Whether bare lids seem to close what walls hold that were taken for noise: votes object, or points lie beside the
/// surface as no noise does.
bool seems_filled(const Points& points, const Attempt& attempt, int threads)
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
    const Points claimed = found.frame.to_unit(points_at(found.claimed, points));
    return !measure_noise_misfit(claimed, crust, noise, threads).is_noise();
}

Mismatch measure_mismatch(const Points& points, const Attempt& attempt, int threads)
{
    return measure_mismatch(attempt.found.frame.to_unit(list_distinct(points, attempt.surface)), crust_of(attempt),
                            threads);
}

/// The crust of the attempt's labels, on its surface.
void make_mesh(Attempt& attempt, const AmlsReconstructionOptions& options, PhaseTimes& times, const Progress& progress)
{
    const LabelledSamples& found = attempt.found;
    times.begin("crust");
    CrustOptions crust;
    crust.keep_components = options.keep_components;
    crust.simplify = options.simplify;
    crust.target_vertices = int(found.samples.size());
    crust.interpolated = &found.samples;
    crust.threads = resolve_threads(options.threads);
    attempt.mesh = make_crust(found.labelled, crust, progress.part(0, 0.5, "crust"), &attempt.dropped);
    found.frame.from_unit_in_place(attempt.mesh.vertices);
    attempt.is_on_surface.assign(attempt.mesh.vertices.size(), 0);
    if (!found.is_exact)
    {
        times.begin("smooth");
        attempt.is_on_surface = smooth_mesh(attempt.mesh, attempt.surface, options.threads,
                                            progress.part(0.5, 1, "projection of the mesh"));
    }
}

/// \param noise 0 = estimate. \param earlier attempt, if there was one.
Attempt attempt_mesh(const Points& points, const AmlsReconstructionOptions& options, double noise,
                     const Attempt* earlier, PhaseTimes& times, const Progress& progress)
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
    Attempt attempt{std::move(surface), std::move(labelled)};
    make_mesh(attempt, options, times, progress.part(0.8, 1));
    return attempt;
}

/// Opens all lids. \param mismatch of the best attempt so far. \returns whether that is clearly better.
bool open_lids(Attempt& attempt, const Points& points, const AmlsReconstructionOptions& options, double mismatch,
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
    make_mesh(attempt, options, times, progress.part(0.7, 1));
    return measure_mismatch(points, attempt, threads).sum() < clearly_better * mismatch;
}

struct WallSearch
{
    std::optional<Attempt> found = {};
    bool has_none = false; ///< Whether there are none to find.
};

/// Walls of one to two spacings read as noise: an attempt without lids with half of it, a quarter, an eighth, if there
/// is one; else that with an eighth and open lids, if the points object to lids and not to these.
WallSearch look_for_walls(const Points& points, const AmlsReconstructionOptions& options, const Attempt& first,
                          PhaseTimes& times, const Progress& progress)
{
    const int threads = resolve_threads(options.threads);
    const double noise = first.surface.report().noise;
    const Mismatch mismatch = measure_mismatch(points, first, threads);
    const PointsAgainst before{mismatch.missed_points, first.found.labelled.violated_votes};
    std::optional<Attempt> last;
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
        if (finds_no_walls(before, {missed, last->found.labelled.violated_votes}))
            return {{}, true};
        if (missed > barely_less * before.missed)
            i = std::max(i, halvings - 1);
    }
    if (last && open_lids(*last, points, options, mismatch.sum(), times, progress.part(0.9, 1)))
        return {std::move(last)};
    return {};
}

} // namespace

AmlsReconstruction reconstruct_amls(const Points& points, const AmlsReconstructionOptions& options,
                                    const Progress& progress)
{
    const ThreadTeam team;
    AmlsReconstruction result;
    PhaseTimes times;
    Attempt attempt = attempt_mesh(points, options, options.noise, nullptr, times, progress.part(0, 0.7));
    const int threads = resolve_threads(options.threads);
    const bool seemed_filled = seems_filled(points, attempt, threads);
    WallSearch walls;
    if (seemed_filled && options.noise == 0)
        walls = look_for_walls(points, options, attempt, times, progress.part(0.7, 0.95));
    if (walls.found)
        attempt = std::move(*walls.found);
    const LabelledSamples& found = attempt.found;
    result.surface = attempt.surface.report();
    result.outliers = found.outliers;
    result.samples = int(found.samples.size()) - found.backs;
    result.completed = found.completed;
    result.violated_votes = found.labelled.violated_votes;
    for (const std::string& text : {describe(attempt.dropped), describe_violation(result.violated_votes)})
        if (!text.empty())
            result.warnings.push_back(text);
    if (found.lost_sheets > 0)
        result.warnings.push_back(describe_backs(found.lost_sheets));
    if (const std::string text = describe_thin_walls(attempt.is_opened, walls.found.has_value(), result.violated_votes);
        !text.empty())
        result.warnings.push_back(text);
    if (seemed_filled && !walls.found && !walls.has_none)
        result.warnings.push_back(
            std::string(lost_walls_text) +
            " Use the filter Surface Reconstruction: Noisy Power Crust, which looks for such walls.");
    times.begin("closing");
    draw_closings_taut(attempt, threads);
    check_encloses_volume(crust_of(attempt));
    times.begin("finish");
    result.mesh = std::move(attempt.mesh);
    std::vector<char>& is_on_surface = attempt.is_on_surface;
    if (options.open_holes)
        open_amls_holes(result.mesh, found, points, is_on_surface, threads, progress.part(0.95, 0.97, "holes"));
    result.vertices_on_surface = int(std::count(is_on_surface.begin(), is_on_surface.end(), 1));
    const NeighbourSearch search(points);
    result.nearest_sample.resize(result.mesh.vertices.size());
    parallel_for(result.mesh.vertices.size(), threads, progress.part(0.97, 1, "nearest points"),
                 [&](std::size_t v) { result.nearest_sample[v] = search.nearest(result.mesh.vertices[v]); });
    const Topology topology = options.open_holes ? measure_topology(result.mesh) : measure_closed_topology(result.mesh);
    result.components = topology.components;
    result.boundary_loops = topology.boundary_loops;
    result.euler_characteristic = topology.euler_characteristic;
    result.genus = topology.genus();
    times.end();
    result.seconds = times.seconds();
    return result;
}

} // namespace recon
