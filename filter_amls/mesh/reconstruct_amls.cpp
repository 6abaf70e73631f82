#include "reconstruct_amls.h"

#include "mesh_attempts.h"

#include <recon/bare_faces/bare_faces.h>
#include <recon/crust/back_sheets.h>
#include <recon/crust/lids.h>
#include <recon/crust/weaving.h>
#include <recon/errors.h>
#include <recon/mesh/convex_surface.h>
#include <recon/mesh/crust_mesh.h>
#include <recon/mesh/mismatch.h>
#include <recon/mesh/taut_closing.h>
#include <recon/mesh/trim.h>
#include <recon/parallel.h>
#include <recon/scan/viewpoint.h>
#include <recon/search/neighbours.h>

#include <algorithm>
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
    for (const int former :
         open_holes(mesh, samples, found.backs, threads, progress, find_viewpoints(points, threads, progress)))
        left.push_back(is_on_surface[former]);
    is_on_surface = std::move(left);
}

/// Over holes of the scan; vertices that move are on the surface no more.
void draw_closings_taut(MeshAttempt& attempt, int threads)
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

/// Share of the points that the mesh misses, beside those of bodies that were left out, if votes give reason to ask.
double measure_missed(const Points& points, const MeshAttempt& attempt, const TriangleMesh& crust, int threads,
                      const Progress& progress)
{
    const LabelledSamples& found = attempt.found;
    if (found.labelled.violated_votes <= suspicious_votes)
        return 0;
    const Points asked = found.is_exact ? found.samples : found.frame.to_unit(points_at(found.claimed, points));
    const double noise = found.is_exact ? 0 : attempt.surface.report().most_noise / found.frame.scale();
    return measure_missed_points(asked, crust, threads, progress, noise) - attempt.dropped.samples;
}

/// Unless something is asked for that the hull has not.
std::optional<ConvexSurface> find_hull(const Points& points, const AmlsReconstructionOptions& options)
{
    if (options.noise != 0 || options.rho_e != 0 || options.open_holes || points.size() > most_points_on_hull)
        return {};
    check_spans_volume(points);
    resolve_threads(options.threads); // throws
    return find_convex_surface(points);
}

AmlsReconstruction take_hull(ConvexSurface hull)
{
    const double spacing = hull.spacing;
    AmlsReconstruction result = result_of<AmlsReconstruction>(std::move(hull));
    result.surface.spacing = spacing;
    return result;
}

/// The attempt that stays.
struct ChosenAttempt
{
    MeshAttempt attempt;
    bool has_found_walls = false;
    bool may_lack_walls = false;
    bool is_between_sheets = false;
    bool has_filled_faces = false;
};

/// The first attempt, or one with other noise.
ChosenAttempt choose_noise(MeshAttempt first, const Points& points, const AmlsReconstructionOptions& options,
                           PhaseTimes& times, const Progress& progress)
{
    ChosenAttempt chosen{std::move(first)};
    if (options.noise != 0)
    {
        chosen.may_lack_walls = seems_filled(points, chosen.attempt, resolve_threads(options.threads));
        return chosen;
    }
    OtherNoise other = look_with_other_noise(points, options, chosen.attempt, times, progress);
    chosen.has_found_walls = other.attempt && !other.is_between_sheets;
    chosen.may_lack_walls = other.may_lack_walls;
    chosen.is_between_sheets = other.is_between_sheets;
    if (other.attempt)
        chosen.attempt = std::move(*other.attempt);
    return chosen;
}

ChosenAttempt choose_attempt(const Points& points, const AmlsReconstructionOptions& options, PhaseTimes& times,
                             const Progress& progress)
{
    MeshAttempt first = attempt_mesh(points, options, options.noise, nullptr, times, progress.part(0, 0.65));
    const AmlsSurface surface = first.surface;
    ChosenAttempt chosen = choose_noise(std::move(first), points, options, times, progress.part(0.65, 0.95));
    if (complete_bare_faces(chosen.attempt, surface, points, options, times, progress.part(0.95, 1, "bare faces")))
    {
        ChosenAttempt filled{std::move(chosen.attempt)};
        filled.has_filled_faces = true;
        return filled;
    }
    return chosen;
}

std::vector<std::string> list_warnings(const ChosenAttempt& chosen)
{
    const LabelledSamples& found = chosen.attempt.found;
    const double violated = found.labelled.violated_votes;
    std::vector<std::string> warnings;
    const auto add = [&](const std::string& text)
    {
        if (!text.empty())
            warnings.push_back(text);
    };
    if (chosen.is_between_sheets)
        add(out_of_register_text);
    if (chosen.has_filled_faces)
        add(filled_faces_text);
    add(describe(chosen.attempt.dropped));
    add(describe_violation(violated));
    if (found.lost_sheets > 0)
        add(describe_backs(found.lost_sheets));
    add(describe_thin_walls(chosen.attempt.is_opened, chosen.has_found_walls, violated));
    if (chosen.may_lack_walls)
        add(std::string(lost_walls_text) +
            " Use the filter Surface Reconstruction: Noisy Power Crust, which looks for such walls.");
    return warnings;
}

AmlsReconstruction reconstruct(const Points& points, const AmlsReconstructionOptions& options, const Progress& progress)
{
    AmlsReconstruction result;
    PhaseTimes times;
    ChosenAttempt chosen = choose_attempt(points, options, times, progress.part(0, 0.94));
    result.warnings = list_warnings(chosen);
    MeshAttempt& attempt = chosen.attempt;
    const int threads = resolve_threads(options.threads);
    const LabelledSamples& found = attempt.found;
    result.surface = attempt.surface.report();
    result.outliers = found.outliers;
    result.samples = int(found.samples.size()) - found.backs;
    result.completed = found.completed;
    if (found.completed > 0)
        result.surface.open = false; // as it looked
    result.violated_votes = found.labelled.violated_votes;
    times.begin("closing");
    draw_closings_taut(attempt, threads);
    const TriangleMesh crust = crust_of(attempt);
    check_encloses_volume(crust);
    times.begin("finish");
    const double missed = measure_missed(points, attempt, crust, threads, progress.part(0.94, 0.95, "points"));
    if (const std::string text = describe_missed(missed); !text.empty() && result.warnings.empty())
        result.warnings.push_back(text);
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

} // namespace

AmlsReconstruction reconstruct_amls(const Points& points, const AmlsReconstructionOptions& options,
                                    const Progress& progress)
{
    const ThreadTeam team;
    return hull_or(
        find_hull(points, options), [&] { return reconstruct(points, options, progress); }, take_hull);
}

} // namespace recon
