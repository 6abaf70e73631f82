#include "reconstruct_amls.h"

#include "project.h"
#include "sample_surface.h"
#include "smooth_mesh.h"
#include "surface_data.h"
#include "thin_walls.h"

#include <recon/back_sheets.h>
#include <recon/block_search.h>
#include <recon/cleanness.h>
#include <recon/crust_mesh.h>
#include <recon/errors.h>
#include <recon/mismatch.h>
#include <recon/neighbours.h>
#include <recon/parallel.h>
#include <recon/taut_closing.h>
#include <recon/trim.h>

#include <algorithm>
#include <functional>
#include <optional>

namespace recon
{
namespace
{

/// Share of flat neighbours above which a cloud may be exact: clean clouds have 0.82 to 1 (but for the coarsest), those
/// with noise of a sixth of the spacing 0.75 to 0.86, of a third 0.56 to 0.6.
constexpr double flat_share = 0.8;
/// Noise between these makes it noisy all the same [spacings, see NoiseEstimate::least_noise()]. Clean clouds have up
/// to 0.094; more than the upper one leaves no flat neighbours, so thin walls read as noise there.
constexpr double least_noise = 0.1, walls = 0.4;
/// Cleanness::whiteness below which it is exact whatever the noise found, as where all is thin walls: 0 to 0.17 there,
/// 0.18 and more with noise of a tenth of the spacing on any shape.
constexpr double exact_whiteness = 0.15;

/// Noise found below which the surface passes through an exact cloud, so that its normals are those of the points:
/// domes, saddles and waves have up to .004, a bust whose folds it rounds off .08 [spacings].
constexpr double resolved = 0.02;

/// Isolated points farther from the others are no part of an exact cloud; nearer ones may be, where it is sparse
/// [diagonals of the others].
constexpr double strange_distance = 0.25;

/// The distinct points, in spatial order as indices of the input, but for isolated ones far from the others.
std::vector<int> list_without_strangers(const Points& points, const AmlsSurface::Data& data)
{
    const auto is_isolated = [&](std::size_t i)
    { return data.cell_normals.kinds[std::size_t(data.cells.cell_of_point[i])] == CellKind::outlier; };
    const std::size_t n = data.points.size();
    Points others;
    for (std::size_t i = 0; i < n; ++i)
        if (!is_isolated(i))
            others.push_back(points[std::size_t(data.spatial.order[i])]);
    if (others.size() == n)
        return data.spatial.order;
    const BlockSearch search(others);
    const double reach = strange_distance * UnitFrame(others).scale();
    std::vector<int> kept;
    for (std::size_t i = 0; i < n; ++i)
    {
        const int k = data.spatial.order[i];
        const Point& p = points[std::size_t(k)];
        if (!is_isolated(i) || (others[std::size_t(search.nearest(p))] - p).norm() <= reach)
            kept.push_back(k);
    }
    return kept;
}

/// What a crust is made of, in a unit frame.
struct LabelledSamples
{
    UnitFrame frame;
    Points samples;
    LabelledBalls labelled;
    int outliers = 0;              ///< Points left out [count].
    bool is_exact = false;         ///< Whether the samples are the points as they are.
    std::vector<int> claimed = {}; ///< Input points that the surface claims, if not exact.
    int backs = 0;                 ///< The last so many samples lie behind sheets that had the outside on both sides.
    double lost_sheets = 0;        ///< Share of samples in such sheets, if they got a back and are no ground [0..1].
    bool is_settled = false;       ///< Whether no other labels are to be tried.
};

void take(LabelledSamples& found, BackedSheets backed)
{
    found.samples = std::move(backed.samples);
    found.labelled = std::move(backed.labelled);
    found.backs = backed.backs;
    found.lost_sheets = backed.share;
}

/// With samples behind sheets that have the outside on both sides and are lost in a cloud that is whole otherwise.
void back_some_sheets(LabelledSamples& found, const LostSheets& lost, bool oriented,
                      const std::function<Vectors(const Progress&)>& list_normals,
                      const BallLabellingOptions& labelling, PhaseTimes& times, const Progress& progress)
{
    if (std::optional<BackedSheets> backed =
            label_with_backs(lost, found.samples, oriented, list_normals, found.labelled, labelling, times, progress))
        take(found, std::move(*backed));
}

/// With samples behind sheets that have the outside on both sides, where that is what the votes object to, or in a
/// scene with a ground. \param violated_as_exact share of votes that labels of the points as they are violate, if these
/// were found.
void back_lost_sheets(LabelledSamples& found, const Vectors& normals, bool is_open, double violated_as_exact,
                      const BallLabellingOptions& labelling, PhaseTimes& times, const Progress& progress)
{
    const double violated = std::max(found.labelled.violated_votes, violated_as_exact);
    LostSheets lost = find_lost_sheets(found.samples, found.labelled, true, labelling.threads);
    const bool has_ground = is_open && add_ground(found.samples, normals, lost);
    const auto back_some = [&]
    {
        const auto list_normals = [&](const Progress&) { return normals; };
        back_some_sheets(found, lost, true, list_normals, labelling, times, progress);
    };
    if (!has_ground && (violated <= open_behind_with_normals || !may_be_a_sheet(lost, is_open, violated)))
        return back_some();
    Points samples = found.samples;
    Vectors all_normals = normals;
    const int backs = back_sheets(lost, samples, all_normals, labelling.threads);
    LabelledBalls backed = label_polar_balls(samples, all_normals, labelling, times, progress);
    if (!has_ground && backed.violated_votes > clearly_backed * violated)
        return back_some();
    take(found, {std::move(samples), std::move(all_normals), std::move(backed), backs, has_ground ? 0 : lost.share});
}

/// Samples of the surface, labelled with its normals. \param violated_as_exact see back_lost_sheets().
LabelledSamples label_surface(const Points& points, const AmlsSurface& surface, double violated_as_exact,
                              const BallLabellingOptions& labelling, PhaseTimes& times, const Progress& progress)
{
    times.begin("projection");
    SurfaceSamples sampled =
        sample_amls_surface(points, surface, labelling.threads, progress.part(0, 0.2, "AMLS projection"));
    if (sampled.samples.points.size() < 4)
        throw AlgorithmFailure("No surface was found among the points: all but " +
                               std::to_string(sampled.samples.points.size()) +
                               " are isolated. Use a denser cloud, or select the part to reconstruct.");
    // Not that of all points: one at the origin of a far coordinate system leaves the others a millionth of it.
    const UnitFrame frame(sampled.outliers > 0 ? sampled.samples.points : points);
    Points samples = frame.to_unit(sampled.samples.points);
    const Vectors& normals = sampled.samples.normals;
    LabelledBalls labelled =
        label_polar_balls(samples, normals, labelling, times, progress.part(0.2, 0.6, "polar balls"));
    LabelledSamples found{frame, std::move(samples),        std::move(labelled), sampled.outliers,
                          false, std::move(sampled.claimed)};
    back_lost_sheets(found, normals, surface.report().open, violated_as_exact, labelling, times,
                     progress.part(0.6, 1, "backs of sheets"));
    return found;
}

/// Whether points are exact as far as can be told.
bool looks_exact(const Cleanness& cleanness, double least_noise_found)
{
    return cleanness.flat_neighbours > flat_share && !cleanness.is_smooth_but_noisy() &&
           !cleanness.is_noisy_in_parts() &&
           (least_noise_found < least_noise || least_noise_found > walls || cleanness.whiteness < exact_whiteness);
}

/// Exact points over a ground, labelled with the surface's normals: without them the ground's votes, which no ball
/// below it answers, cancel and make it lace. None if there is no ground.
std::optional<LabelledSamples> label_exact_scene(const UnitFrame& frame, const Points& samples, const Vectors& normals,
                                                 int isolated, const BallLabellingOptions& labelling, PhaseTimes& times,
                                                 const Progress& progress)
{
    LostSheets none;
    if (!add_ground(samples, normals, none))
        return {};
    LabelledBalls labelled =
        label_polar_balls(samples, normals, labelling, times, progress.part(0, 0.5, "polar balls"));
    LabelledSamples found{frame, samples, std::move(labelled), isolated, true};
    back_lost_sheets(found, normals, true, 0, labelling, times, progress.part(0.5, 1, "backs of sheets"));
    found.is_settled = true;
    return found;
}

/// Exact points, which are themselves the best samples: walls thinner than the width have no other. None if they are
/// not exact, or too open.
std::optional<LabelledSamples> label_exact_points(const Points& points, const AmlsSurface& surface,
                                                  const BallLabellingOptions& labelling, PhaseTimes& times,
                                                  const Progress& progress)
{
    times.begin("gate");
    const std::vector<int> kept = list_without_strangers(points, surface.data());
    const int isolated = int(surface.data().points.size() - kept.size());
    Points distinct = points_at(kept, points);
    // Not that of all points, see label_surface().
    const UnitFrame frame(isolated > 0 ? distinct : points);
    distinct = frame.to_unit(distinct);
    const AmlsSurfaceReport& report = surface.report();
    const Cleanness cleanness = measure_cleanness(distinct, labelling.threads);
    if (!looks_exact(cleanness, report.least_noise))
        return {};
    std::optional<Vectors> known; // asked for up to three times
    const auto list_normals = [&](const Progress& part)
    {
        if (!known)
            known = points_at(kept, list_surface_normals(points, surface, labelling.threads, part));
        return *known;
    };
    if (report.open)
        if (auto scene = label_exact_scene(frame, distinct, list_normals(progress.part(0, 0.1)), isolated, labelling,
                                           times, progress.part(0.1, 1)))
            return scene;
    LabelledBalls labelled = label_polar_balls(distinct, {}, labelling, times, progress.part(0.1, 0.5, "polar balls"));
    // So open a cloud, as a shallow dome, needs the surface's normals, which are those of the points where it passes
    // through them.
    if (labelled.violated_votes > flooded_above && report.noise < resolved * report.spacing)
        labelled =
            label_polar_balls(distinct, list_normals({}), labelling, times, progress.part(0.5, 1, "polar balls"));
    if (labelled.violated_votes > flooded_above)
        return {};
    if (std::optional<LabelledBalls> better = label_thin_walls(distinct, cleanness.stacked, list_normals, labelling,
                                                               labelled, times, progress.part(0.5, 1, "thin walls")))
        labelled = std::move(*better);
    LabelledSamples found{frame, std::move(distinct), std::move(labelled), isolated, true};
    const LostSheets lost = find_lost_sheets(found.samples, found.labelled, false, labelling.threads);
    if (lost.largest <= bearable_lost)
        back_some_sheets(found, lost, false, list_normals, labelling, times, progress.part(0.5, 1, "backs of sheets"));
    return found;
}

/// How far the crust of the labels and the points part.
double measure_mismatch(const LabelledSamples& found, const Points& points, int threads)
{
    const LabelledBalls& labelled = found.labelled;
    const TriangleMesh crust =
        triangulate_polygons(list_crust_polygons(labelled.regular, labelled.labels, threads), threads);
    return measure_mismatch(found.frame.to_unit(points), crust, threads).sum();
}

/// Exact points as they are, unless their crust contradicts them, as where the deep hollow of a scan is filled, and
/// that of the surface's samples does less.
LabelledSamples label_points(const Points& points, const AmlsSurface& surface, bool may_be_exact,
                             const BallLabellingOptions& labelling, PhaseTimes& times, const Progress& progress)
{
    std::optional<LabelledSamples> exact;
    if (may_be_exact)
        exact = label_exact_points(points, surface, labelling, times, progress.part(0, 0.5));
    if (!exact)
        return label_surface(points, surface, 0, labelling, times, progress.part(0.5, 1));
    const double violated = exact->labelled.violated_votes;
    if (exact->is_settled || violated <= suspicious_votes)
        return std::move(*exact);
    times.begin("mismatch");
    const double mismatch = measure_mismatch(*exact, points, labelling.threads);
    const bool has_lost_sheets =
        violated > open_behind &&
        find_lost_sheets(exact->samples, exact->labelled, false, labelling.threads).largest > bearable_lost;
    if (mismatch <= bearable_mismatch && !has_lost_sheets)
        return std::move(*exact);
    LabelledSamples projected =
        label_surface(points, surface, has_lost_sheets ? violated : 0, labelling, times, progress.part(0.5, 1));
    times.begin("mismatch");
    // Backs of sheets are bare.
    const bool is_better = has_lost_sheets && projected.lost_sheets > 0
                               ? projected.labelled.violated_votes <= clearly_backed * violated
                               : projected.labelled.violated_votes < violated &&
                                     measure_mismatch(projected, points, labelling.threads) < mismatch;
    return is_better ? std::move(projected) : std::move(*exact);
}

/// Whether bare lids seem to close what walls hold that were taken for noise.
bool seems_filled(const Points& points, const TriangleMesh& mesh, const LabelledSamples& found, double noise,
                  int threads)
{
    const TriangleMesh crust{found.frame.to_unit(mesh.vertices), mesh.triangles, {}};
    if (noise < least_noise_of_walls * found.labelled.spacing * found.frame.scale() ||
        measure_bare_area(found.samples, crust, threads) <= bare_lid)
        return false;
    const Points claimed = found.frame.to_unit(points_at(found.claimed, points));
    return !measure_noise_misfit(claimed, crust, noise / found.frame.scale(), threads).is_noise();
}

/// Over holes of the scan. \param is_on_surface loses the vertices that move.
void draw_closings_taut(TriangleMesh& mesh, const LabelledSamples& found, std::vector<char>& is_on_surface, int threads)
{
    const Points before = found.frame.to_unit(mesh.vertices);
    TriangleMesh taut{before, mesh.triangles, {}};
    if (draw_bare_faces_taut(taut, found.samples, threads) == 0)
        return;
    for (std::size_t v = 0; v < before.size(); ++v)
        if (taut.vertices[v] != before[v])
        {
            is_on_surface[v] = 0;
            mesh.vertices[v] = found.frame.from_unit(taut.vertices[v]);
        }
}

/// \param is_on_surface loses the vertices that go.
void open_amls_holes(TriangleMesh& mesh, const LabelledSamples& found, std::vector<char>& is_on_surface, int threads,
                     const Progress& progress)
{
    Points samples = found.samples;
    found.frame.from_unit_in_place(samples);
    std::vector<char> left;
    for (const int former : open_holes(mesh, samples, found.backs, threads, progress))
        left.push_back(is_on_surface[former]);
    is_on_surface = std::move(left);
}

} // namespace

AmlsReconstruction reconstruct_amls(const Points& points, const AmlsReconstructionOptions& options,
                                    const Progress& progress)
{
    AmlsReconstruction result;
    PhaseTimes times;
    times.begin("surface");
    AmlsOptions surface_options;
    surface_options.rho_e = options.rho_e;
    surface_options.noise = options.noise;
    surface_options.threads = options.threads;
    surface_options.terrain_faces_up = false; // see there
    const AmlsSurface surface = build_amls_surface(points, surface_options, progress.part(0, 0.3, "AMLS surface"));
    result.surface = surface.report();

    BallLabellingOptions labelling;
    labelling.share_balls = true;              // the crust goes through the samples
    labelling.limit = BallLimit::fewest_votes; // of exact points
    labelling.threads = resolve_threads(options.threads);
    LabelledSamples found =
        label_points(points, surface, options.noise == 0, labelling, times, progress.part(0.3, 0.75, "labels"));
    result.outliers = found.outliers;
    result.samples = int(found.samples.size()) - found.backs;
    result.violated_votes = found.labelled.violated_votes;
    times.begin("crust");
    CrustOptions crust;
    crust.keep_components = options.keep_components;
    crust.simplify = options.simplify;
    crust.target_vertices = int(found.samples.size());
    crust.interpolated = &found.samples;
    crust.threads = labelling.threads;
    DroppedBodies dropped;
    result.mesh = make_crust(found.labelled, crust, progress.part(0.75, 0.85, "crust"), &dropped);
    for (const std::string& text : {describe(dropped), describe_violation(result.violated_votes)})
        if (!text.empty())
            result.warnings.push_back(text);
    if (found.lost_sheets > 0)
        result.warnings.push_back(describe_backs(found.lost_sheets));
    found.frame.from_unit_in_place(result.mesh.vertices);
    std::vector<char> is_on_surface(result.mesh.vertices.size(), 0);
    if (!found.is_exact)
    {
        times.begin("smooth");
        is_on_surface =
            smooth_mesh(result.mesh, surface, options.threads, progress.part(0.85, 0.95, "projection of the mesh"));
        if (seems_filled(points, result.mesh, found, result.surface.noise, labelling.threads))
            result.warnings.push_back(
                std::string(lost_walls_text) +
                " Use the filter Surface Reconstruction: Noisy Power Crust, which looks for such walls.");
    }
    times.begin("closing");
    draw_closings_taut(result.mesh, found, is_on_surface, labelling.threads);
    times.begin("finish");
    if (options.open_holes)
        open_amls_holes(result.mesh, found, is_on_surface, labelling.threads, progress.part(0.95, 0.97, "holes"));
    result.vertices_on_surface = int(std::count(is_on_surface.begin(), is_on_surface.end(), 1));
    const NeighbourSearch search(points);
    result.nearest_sample.resize(result.mesh.vertices.size());
    parallel_for(result.mesh.vertices.size(), labelling.threads, progress.part(0.97, 1, "nearest points"),
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
