#include "label_points.h"

#include "filter_amls/cells/isolated_points.h"
#include "filter_amls/surface/sample_surface.h"
#include "filter_amls/surface/surface_data.h"
#include "open_sheets.h"
#include "thin_tubes.h"
#include "thin_walls.h"

#include <recon/bare_faces/label_flats.h>
#include <recon/bare_faces/label_noisy_flats.h>
#include <recon/crust/back_sheets.h>
#include <recon/crust/weaving.h>
#include <recon/errors.h>
#include <recon/mesh/crust_mesh.h>
#include <recon/mesh/mismatch.h>
#include <recon/noise/cleanness.h>
#include <recon/search/block_search.h>

#include <algorithm>
#include <functional>

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

/// Cleanness::least_roughness below which a clean cloud is exact, however coarse: there noise is found everywhere, but
/// a quadric follows a tenth of the places closely. Coarse models have up to 0.048, with noise of a tenth of the
/// spacing 0.051 to 0.091.
constexpr double exact_roughness = 0.05;

/// Share of points that the crust of a scene misses where its ground is lost: 0.92 and 0.93, else 0.01.
constexpr double many_missed = 0.3;

/// Share of the votes that thin tubes' denoised labels violate at least, where these are not made.
constexpr double least_violated_denoised = 0.001;

/// The distinct points, in spatial order as indices of the input, but for isolated ones.
std::vector<int> list_without_isolated(const Points& points, const AmlsSurface::Data& data, int threads)
{
    const std::vector<int> isolated =
        list_isolated_points(data.points, data.point_search, data.cells, data.cell_normals, threads);
    return isolated.empty() ? data.spatial.order : order_without(isolated, data.spatial.order, points);
}

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
void back_lost_sheets(LabelledSamples& found, const Vectors& normals, const AmlsSurfaceReport& report,
                      double violated_as_exact, const BallLabellingOptions& labelling, PhaseTimes& times,
                      const Progress& progress)
{
    const bool is_open = report.open;
    const double violated = std::max(found.labelled.violated_votes, violated_as_exact);
    LostSheets lost = find_lost_sheets(found.samples, found.labelled, true, labelling.threads, progress.part(0, 0));
    const bool has_ground = is_open && add_ground(found.samples, normals, lost, labelling.threads);
    if (is_open && !has_ground)
        if (auto sheet = back_open_sheet(found.samples, normals, found.labelled, !report.seen_from.empty(), labelling,
                                         times, progress))
            return take(found, std::move(*sheet));
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
    const BallLabellingOptions fewer = has_ground ? labelling : labelling.within(clearly_backed * violated);
    LabelledBalls backed = label_polar_balls(samples, all_normals, fewer, times, progress);
    if (backed.violated_votes > fewer.most_violated)
        return back_some();
    take(found, {std::move(samples), std::move(all_normals), std::move(backed), backs, has_ground ? 0 : lost.share});
}

/// Completes bare flat faces, unless votes are against it.
void complete_flats(LabelledSamples& found, const Points& points, const AmlsSurface& surface,
                    const BallLabellingOptions& labelling, PhaseTimes& times, const Progress& progress)
{
    const Points distinct = found.frame.to_unit(points_at(surface.data().spatial.order, points));
    const double noise = surface.report().noise / found.frame.scale();
    const DenoisedCloud cloud{distinct, noise, found.samples, found.normals};
    std::optional<CrustPolygons> polygons;
    std::optional<LabelledNoisyFlats> flats = label_with_noisy_flats(
        cloud, found.labelled, noise, label_within(labelling, times, progress.part(0, 1, "polar balls")), polygons,
        times, labelling.threads);
    if (!flats)
        return;
    found.samples = std::move(flats->samples);
    found.normals = std::move(flats->normals);
    found.labelled = std::move(flats->labelled);
    found.completed = flats->added;
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
    Vectors normals = std::move(sampled.samples.normals);
    LabelledBalls labelled =
        label_polar_balls(samples, normals, labelling, times, progress.part(0.2, 0.5, "polar balls"));
    LabelledSamples found{frame, std::move(samples),         std::move(labelled), sampled.outliers,
                          false, std::move(sampled.claimed), std::move(normals)};
    complete_flats(found, points, surface, labelling, times, progress.part(0.5, 0.7, "flat faces"));
    // Bare flats explain sheets without an inside.
    if (found.completed == 0)
        back_lost_sheets(found, found.normals, surface.report(), violated_as_exact, labelling, times,
                         progress.part(0.7, 1, "backs of sheets"));
    if (found.backs > 0)
        found.normals.clear();
    return found;
}

/// Samples of the surface, labelled once, where they are asked for.
class SurfaceAttempt
{
public:
    SurfaceAttempt(const Points& points, const AmlsSurface& surface, const BallLabellingOptions& labelling,
                   PhaseTimes& times)
        : points(points), surface(surface), labelling(labelling), times(times)
    {
    }

    LabelledSamples& get(const Progress& progress)
    {
        if (!made_)
            made_ = label_surface(points, surface, 0, labelling, times, progress);
        return *made_;
    }
    /// None where nothing is inside.
    LabelledSamples* find(const Progress& progress)
    {
        try
        {
            return &get(progress);
        }
        catch (const AlgorithmFailure&)
        {
            return nullptr;
        }
    }

    const Points& points;
    const AmlsSurface& surface;
    const BallLabellingOptions& labelling;
    PhaseTimes& times;

private:
    std::optional<LabelledSamples> made_;
};

/// Whether points are exact as far as can be told.
bool looks_exact(const Cleanness& cleanness, double least_noise_found)
{
    if (cleanness.is_smooth_but_noisy() || cleanness.is_noisy_in_parts())
        return false;
    if (cleanness.is_clean() && cleanness.least_roughness < exact_roughness)
        return true;
    return cleanness.flat_neighbours > flat_share &&
           (least_noise_found < least_noise || least_noise_found > walls || cleanness.whiteness < exact_whiteness);
}

/// The crust of the labels, in the frame.
TriangleMesh list_crust(const LabelledSamples& found, int threads)
{
    const LabelledBalls& labelled = found.labelled;
    return triangulate_polygons(list_crust_polygons(labelled.regular, labelled.labels, threads), threads);
}

/// Exact points over a ground, labelled with the surface's normals: without them the ground's votes, which no ball
/// below it answers, cancel and make it lace. None if there is no ground, or it is lost all the same, as where lines of
/// points are far from each other.
std::optional<LabelledSamples> label_exact_scene(const UnitFrame& frame, const Points& samples, const Vectors& normals,
                                                 int isolated, const AmlsSurfaceReport& report,
                                                 const BallLabellingOptions& labelling, PhaseTimes& times,
                                                 const Progress& progress)
{
    LostSheets none;
    if (!add_ground(samples, normals, none, labelling.threads))
        return {};
    LabelledBalls labelled =
        label_polar_balls(samples, normals, labelling, times, progress.part(0, 0.5, "polar balls"));
    LabelledSamples found{frame, samples, std::move(labelled), isolated, true};
    back_lost_sheets(found, normals, report, 0, labelling, times, progress.part(0.5, 1, "backs of sheets"));
    if (found.labelled.violated_votes > suspicious_votes &&
        measure_missed_points(samples, list_crust(found, labelling.threads), labelling.threads) > many_missed)
        return {};
    found.is_settled = true;
    return found;
}

/// The distinct points, but for isolated ones.
struct PointsAsTheyAre
{
    PointsAsTheyAre(const Points& points, const AmlsSurface& surface, int threads)
        : kept(list_without_isolated(points, surface.data(), threads)),
          isolated(int(surface.data().points.size() - kept.size())), distinct(points_at(kept, points)),
          frame(isolated > 0 ? distinct : points)
    {
        distinct = frame.to_unit(distinct);
        cleanness = measure_cleanness(distinct, threads);
    }

    std::vector<int> kept;
    int isolated;
    Points distinct; ///< In the frame, in spatial order.
    UnitFrame frame; ///< Not that of all points, see label_surface().
    Cleanness cleanness;
};

/// Exact points whose bare flat faces could be completed, see complete_flats.h: no open scan has such. \param
/// label_plain labels of the points without these.
std::optional<LabelledSamples> label_bare_flats(const PointsAsTheyAre& as_they_are,
                                                const std::function<const LabelledBalls&()>& label_plain,
                                                bool are_exact, const BallLabellingOptions& labelling,
                                                PhaseTimes& times, const Progress& progress)
{
    std::optional<FlatCompletion> completion;
    const auto complete = [&]
    {
        if (!completion)
        {
            times.begin("flat faces");
            FlatFaceOptions options;
            options.threads = labelling.threads;
            completion = complete_flats(as_they_are.distinct, options, progress.part(0, 0.2, "flat faces"));
        }
        return *completion;
    };
    // Else such faces are what says that the points are exact, and plain labels are of no other use.
    if (!are_exact && complete().points.empty())
        return {};
    std::optional<LabelledFlats> found =
        label_with_flats(as_they_are.distinct, complete, label_plain().violated_votes,
                         label_within(labelling, times, progress.part(0.2, 1, "polar balls")));
    if (!found)
        return {};
    LabelledSamples result{as_they_are.frame, std::move(found->samples), std::move(found->labelled),
                           as_they_are.isolated, true};
    result.completed = found->added;
    result.is_settled = true;
    return result;
}

/// Samples of the surface, if the crust of the points as they are weaves through the noise of an open cloud.
std::optional<LabelledSamples> label_if_woven(const LabelledSamples& exact, SurfaceAttempt& attempt,
                                              const Progress& progress)
{
    const auto list_signs = [&](const LabelledSamples& found)
    {
        return WeavingSigns{found.labelled.violated_votes,
                            measure_closed_topology(list_crust(found, attempt.labelling.threads)).genus()};
    };
    if (exact.labelled.violated_votes <= suspicious_votes)
        return {};
    const WeavingSigns woven = list_signs(exact);
    if (!may_weave_through_noise(woven))
        return {};
    LabelledSamples* denoised = attempt.find(progress);
    if (!denoised || !weaves_through_noise(woven, list_signs(*denoised)))
        return {};
    denoised->is_settled = true;
    return std::move(*denoised);
}

/// A slab of exact points, unless it misses much, and one of the surface's samples half of that at most.
LabelledSamples label_surface_if_slab_misses(LabelledSamples slab, SurfaceAttempt& attempt, const Progress& progress)
{
    const int threads = attempt.labelling.threads;
    const Points distinct = points_at(attempt.surface.data().spatial.order, attempt.points);
    const auto measure_missed = [&](const LabelledSamples& found)
    { return measure_missed_points(found.frame.to_unit(distinct), list_crust(found, threads), threads); };
    const double missed = measure_missed(slab);
    if (missed <= much_missed)
        return slab;
    LabelledSamples* denoised = attempt.find(progress);
    if (!denoised || denoised->backs == 0 || measure_missed(*denoised) > clearly_backed * missed)
        return slab;
    denoised->is_settled = true;
    return std::move(*denoised);
}

/// Exact points, which are themselves the best samples: walls thinner than the width have no other. None if they are
/// not exact as far as can be told, or too open.
std::optional<LabelledSamples> label_exact_points(const PointsAsTheyAre& as_they_are, SurfaceAttempt& attempt,
                                                  const Progress& progress)
{
    const Points& points = attempt.points;
    const AmlsSurface& surface = attempt.surface;
    const BallLabellingOptions& labelling = attempt.labelling;
    PhaseTimes& times = attempt.times;
    const AmlsSurfaceReport& report = surface.report();
    const Points& distinct = as_they_are.distinct;
    const int isolated = as_they_are.isolated;
    std::optional<LabelledBalls> plain; // asked for up to twice
    const auto label_plain = [&]() -> LabelledBalls&
    {
        // Points that may be exact are labelled by options_for_labels(), as that crust is.
        const CrustOfPoints::Made* made = isolated == 0 ? surface.data().crust->made() : nullptr;
        if (!plain)
            plain = made ? made->labelled
                         : label_polar_balls(distinct, {}, labelling, times, progress.part(0.1, 0.5, "polar balls"));
        return *plain;
    };
    const bool are_exact = looks_exact(as_they_are.cleanness, report.least_noise);
    if (auto flats = label_bare_flats(as_they_are, label_plain, are_exact, labelling, times, progress.part(0, 0.1)))
        return flats;
    if (!are_exact)
        return {};
    std::optional<Vectors> known; // asked for up to three times
    const auto list_normals = [&](const Progress& part)
    {
        if (!known)
            known = points_at(as_they_are.kept, list_surface_normals(points, surface, labelling.threads, part));
        return *known;
    };
    if (report.open)
        if (auto scene = label_exact_scene(as_they_are.frame, distinct, list_normals(progress.part(0, 0.1)), isolated,
                                           report, labelling, times, progress.part(0.1, 1)))
            return scene;
    LabelledSamples found{as_they_are.frame, distinct, std::move(label_plain()), isolated, true};
    if (report.open)
        if (auto denoised = label_if_woven(found, attempt, progress.part(0.1, 0.5)))
            return denoised;
    if (report.open && may_lack_sheets(found.samples, found.labelled, labelling.threads))
        if (auto sheet = label_open_sheet(found.samples, list_normals({}), labelling, times, progress.part(0.5, 0.75)))
        {
            take(found, std::move(*sheet));
            found.is_settled = true;
            return label_surface_if_slab_misses(std::move(found), attempt, progress.part(0.75, 1));
        }
    if (found.labelled.violated_votes > flooded_above)
        return {};
    if (std::optional<LabelledBalls> better =
            label_thin_walls(found.samples, as_they_are.cleanness.stacked, list_normals, labelling, found.labelled,
                             times, progress.part(0.5, 1, "thin walls")))
        found.labelled = std::move(*better);
    found.least_roughness = as_they_are.cleanness.least_roughness;
    const LostSheets lost =
        find_lost_sheets(found.samples, found.labelled, false, labelling.threads, progress.part(0.5, 0.5));
    if (lost.largest <= bearable_lost)
        back_some_sheets(found, lost, false, list_normals, labelling, times, progress.part(0.5, 1, "backs of sheets"));
    return found;
}

/// The points as they are, if they are thin tubes'. \param violated share of votes that denoised labels violate.
std::optional<LabelledSamples> label_tubes(const PointsAsTheyAre& as_they_are, double violated,
                                           const BallLabellingOptions& labelling, PhaseTimes& times,
                                           const Progress& progress)
{
    const Cleanness& cleanness = as_they_are.cleanness;
    if (!may_be_tubes(cleanness.share(), cleanness.is_doubtful(), violated))
        return {};
    try
    {
        BallLabellingOptions options = labelling;
        options.limit = BallLimit::fine;
        options.most_violated = most_violated_by_tubes;
        LabelledBalls labelled =
            label_polar_balls(as_they_are.distinct, {}, options, times, progress.part(0, 1, "points as they are"));
        if (!are_tubes(labelled.violated_votes, violated))
            return {};
        LabelledSamples found{as_they_are.frame, as_they_are.distinct, std::move(labelled), as_they_are.isolated, true};
        found.least_roughness = cleanness.least_roughness;
        return found;
    }
    catch (const AlgorithmFailure&) // nothing is inside
    {
        return {};
    }
}

/// Exact points as they are, unless their crust contradicts them, as where the deep hollow of a scan is filled, and
/// that of the surface's samples does less: then these.
LabelledSamples label_surface_if_better(LabelledSamples exact, SurfaceAttempt& attempt, const Progress& progress)
{
    const Points& points = attempt.points;
    const AmlsSurface& surface = attempt.surface;
    const BallLabellingOptions& labelling = attempt.labelling;
    PhaseTimes& times = attempt.times;
    const double violated = exact.labelled.violated_votes;
    if (exact.is_settled || violated <= suspicious_votes)
        return exact;
    times.begin("mismatch");
    // Without copies, which would leave points without a spacing.
    const Points distinct = points_at(surface.data().spatial.order, points);
    const TriangleMesh exact_crust = list_crust(exact, labelling.threads);
    const Mismatch mismatch = measure_mismatch(exact.frame.to_unit(distinct), exact_crust, labelling.threads);
    const bool has_lost_sheets =
        violated > open_behind &&
        find_lost_sheets(exact.samples, exact.labelled, false, labelling.threads, progress.part(0, 0)).largest >
            bearable_lost;
    if (mismatch.missed_points <= bearable_miss && mismatch.sum() <= bearable_mismatch && !has_lost_sheets)
        return exact;
    LabelledSamples projected = has_lost_sheets ? label_surface(points, surface, violated, labelling, times, progress)
                                                : std::move(attempt.get(progress));
    times.begin("mismatch");
    const TriangleMesh crust = list_crust(projected, labelling.threads);
    // Backs of sheets are bare.
    const bool has_better_labels =
        has_lost_sheets && projected.lost_sheets > 0
            ? projected.labelled.violated_votes <= clearly_backed * violated
            : projected.labelled.violated_votes < violated &&
                  measure_mismatch(projected.frame.to_unit(distinct), crust, labelling.threads).sum() < mismatch.sum();
    return has_better_labels ? std::move(projected) : std::move(exact);
}

} // namespace

LabelledSamples label_points(const Points& points, const AmlsSurface& surface, bool may_be_exact,
                             const BallLabellingOptions& labelling, PhaseTimes& times, const Progress& progress)
{
    if (!may_be_exact || surface.report().lattice_step > 0)
        return label_surface(points, surface, 0, labelling, times, progress.part(0.5, 1));
    times.begin("gate");
    const PointsAsTheyAre as_they_are(points, surface, labelling.threads);
    SurfaceAttempt attempt(points, surface, labelling, times);
    if (std::optional<LabelledSamples> exact = label_exact_points(as_they_are, attempt, progress.part(0, 0.5)))
        return label_surface_if_better(std::move(*exact), attempt, progress.part(0.5, 1));
    return label_unless_tubes([&] { return std::move(attempt.get(progress.part(0.5, 0.85))); },
                              [&](const std::optional<LabelledSamples>& found)
                              {
                                  return label_tubes(as_they_are, found ? found->labelled.violated_votes : 1, labelling,
                                                     times, progress.part(0.85, 1));
                              });
}

std::optional<LabelledSamples> label_only_tubes(const Points& points, const AmlsSurface& surface,
                                                const BallLabellingOptions& labelling, PhaseTimes& times,
                                                const Progress& progress)
{
    if (surface.report().lattice_step > 0)
        return {};
    times.begin("gate");
    const PointsAsTheyAre as_they_are(points, surface, labelling.threads);
    if (!as_they_are.cleanness.is_doubtful())
        return {};
    return label_tubes(as_they_are, least_violated_denoised, labelling, times, progress);
}

bool is_open_sheet(const AmlsSurface& surface)
{
    return surface.report().open && !lie_along_lines(surface.data().points, surface.data().point_search);
}

std::optional<LabelledSamples> label_only_flats(const Points& points, const AmlsSurface& surface,
                                                const BallLabellingOptions& labelling, PhaseTimes& times,
                                                const Progress& progress)
{
    if (is_open_sheet(surface))
        return {};
    LabelledSamples found = label_points(points, surface, true, labelling, times, progress);
    return found.completed > 0 ? std::optional(std::move(found)) : std::nullopt;
}

} // namespace recon
