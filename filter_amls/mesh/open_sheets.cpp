#include "open_sheets.h"

#include <recon/mesh/crust_mesh.h>
#include <recon/mesh/mismatch.h>
#include <recon/search/block_search.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>
#include <vector>

namespace recon
{
namespace
{

/// Mean thickness below which the lid of what is as shallow as a saddle lies beside much of the sheet [spacings].
constexpr double thinnest_lidded = 7;

/// Handles per sample that a slab may have which is not whole but lacks half of what the lidded crust does, as at
/// pixels that fly between two depths: each hole of a sheet, as the shadow of what stands on it, is one.
constexpr double many_holes = 2e-3;

/// What a slab may lack of what the lidded crust does where the places of scanners are known, since nothing was seen
/// from behind: three real sweeps lack 0.51 to 0.76, and 0.05 of all readings more are reached. If it violates half of
/// the votes only, it may lack as much (0.9, and 0.12 more are reached from the front).
constexpr double less_lack = 0.8;

/// Share of votes above which a slab of which no scanner is known must halve those of the lidded crust: 0.02 at most
/// object to slabs of sheets, 0.04 to 0.055 where the backs of thin walls came through the walls.
constexpr double through_walls = 0.03;

/// Of a slab's second attempt [spacings].
constexpr double other_thickness = 4;
/// Of a body closed by itself: least triangles [count], and mean thickness, below which it may be a shred between sheet
/// and lid, and backs would have no room [spacings].
constexpr std::size_t least_body = 100;
constexpr double thinnest_body = 3;
/// Of a body that is all there is, bare share of the area up to which no part of it is open: what it leaves out are
/// sheets within. Sheets closed by a lid as thick have 0.4.
constexpr double bare_alone = 0.05;
/// Above this a slab, which has twice as many, takes too much memory [samples].
constexpr std::size_t most_backed = 1'000'000;

/// A crust, and what it lacks of an open sheet.
struct Found
{
    TriangleMesh crust;
    LostSheets lost;
    double missed = 0;   ///< Share of the samples [0..1].
    double violated = 0; ///< Of the votes [0..1].
    int handles = 0;
    double spacing = 0;   ///< Of the samples [length].
    double thickness = 0; ///< [spacings]

    bool is_whole() const { return lost.around.empty() && missed <= bearable_miss; }
    bool is_flat() const { return thickness < thinnest_lidded; }
    bool lacks_much() const { return missed > much_missed || lost.share > bearable_lost; }
    double lack() const { return missed + lost.share; }
};

Found look_at(const Points& samples, const LabelledBalls& labelled, int threads)
{
    Found found;
    found.crust = triangulate_polygons(list_crust_polygons(labelled.regular, labelled.labels, threads), threads);
    found.lost = find_lost_sheets(samples, labelled, true, threads);
    found.violated = labelled.violated_votes;
    found.missed = measure_missed_points(samples, found.crust, threads);
    found.handles = measure_closed_topology(found.crust).genus();
    found.spacing = labelled.spacing;
    found.thickness = measure_thickness(found.crust) / found.spacing;
    return found;
}

/// Whether each component of a mesh is the nearest one of some sample.
bool is_all_seen(const TriangleMesh& mesh, const Points& samples)
{
    const MeshComponents components = find_components(mesh);
    const BlockSearch search(mesh.vertices);
    std::vector<char> is_seen(std::size_t(components.count), 0);
    for (const Point& sample : samples)
        is_seen[std::size_t(components.of_vertex[std::size_t(search.nearest(sample))])] = 1;
    return std::count(is_seen.begin(), is_seen.end(), 0) == 0;
}

/// Per sample: 1 if it is of no body that the crust closes without a lid, as a ball over a terrain, which needs no
/// back.
std::vector<double> mark_open(const TriangleMesh& crust, const Points& samples, double spacing, int threads)
{
    std::vector<double> is_open(samples.size(), 1);
    if (crust.triangles.empty())
        return is_open;
    const MeshComponents components = find_components(crust);
    const double most_bare = components.count > 1 ? bare_lid : bare_alone;
    std::vector<std::vector<std::array<int, 3>>> bodies(std::size_t(components.count));
    for (std::size_t i = 0; i < crust.triangles.size(); ++i)
        bodies[std::size_t(components.of_triangle[i])].push_back(crust.triangles[i]);
    std::vector<char> is_closed;
    TriangleMesh body;
    body.vertices = crust.vertices;
    for (std::vector<std::array<int, 3>>& triangles : bodies)
    {
        body.triangles = std::move(triangles);
        is_closed.push_back(body.triangles.size() >= least_body && measure_thickness(body) >= thinnest_body * spacing &&
                            measure_bare_area(samples, body, threads) <= most_bare);
    }
    const BlockSearch search(crust.vertices);
    for (std::size_t i = 0; i < samples.size(); ++i)
        is_open[i] = !is_closed[std::size_t(components.of_vertex[std::size_t(search.nearest(samples[i]))])];
    return is_open;
}

/// Normals tell the sides, and the votes object at the rim whether balls are shared or not.
BallLabellingOptions options_for_sheets(BallLabellingOptions options)
{
    if (options.sharing == BallSharing::undisputed)
        options.sharing = BallSharing::always;
    return options;
}

/// A sheet with a back behind all of it.
struct Slab
{
    BackedSheets sheets;
    Found found;
};

Slab make_slab(const Points& samples, const Vectors& normals, const LostSheets& open, double thickness,
               const BallLabellingOptions& options, PhaseTimes& times, const Progress& progress)
{
    Points both = samples;
    Vectors both_normals = normals;
    const int backs = back_sheets(open, both, both_normals, options.threads, thickness);
    LabelledBalls labelled = label_polar_balls(both, both_normals, options, times, progress);
    times.begin("backs of sheets");
    Found found = look_at(samples, labelled, options.threads);
    return {{std::move(both), std::move(both_normals), std::move(labelled), backs, open.share}, std::move(found)};
}

/// None if it is no better than what was closed by a lid. \param is_seen see back_open_sheet().
std::optional<BackedSheets> back_all(const Points& samples, const Vectors& normals, const Found& lidded, bool is_seen,
                                     const BallLabellingOptions& options, PhaseTimes& times, const Progress& progress)
{
    if (samples.size() > most_backed)
        return {};
    LostSheets open{mark_open(lidded.crust, samples, lidded.spacing, options.threads)};
    open.share = std::accumulate(open.around.begin(), open.around.end(), 0.0) / double(samples.size());
    if (open.share == 0)
        return {};
    Slab best = make_slab(samples, normals, open, usual_thickness, options, times, progress.part(0, 0.6));
    // Gaps between random samples can be tunnels through it, but hardly through both. What lacks parts, as foliage, has
    // dozens through either.
    if (best.found.handles > 0 && best.found.is_whole())
        if (Slab other = make_slab(samples, normals, open, other_thickness, options, times, progress.part(0.6, 1));
            other.found.handles < best.found.handles)
            best = std::move(other);
    const Found& backed = best.found;
    const bool has_fewer_handles =
        backed.handles < lidded.handles || (lidded.is_flat() && backed.handles == lidded.handles);
    const int most_handles = std::max(lidded.handles, int(many_holes * double(samples.size())));
    const double lack_left = !is_seen                                              ? clearly_backed
                             : backed.violated <= clearly_backed * lidded.violated ? 1
                                                                                   : less_lack;
    const bool lacks_less = backed.lack() <= lack_left * lidded.lack() && backed.handles <= most_handles;
    const bool comes_through = !is_seen && backed.violated > std::max(through_walls, clearly_backed * lidded.violated);
    const bool is_better =
        !comes_through &&
        (lidded.is_whole() ? backed.is_whole() && has_fewer_handles : backed.is_whole() || lacks_less) &&
        is_all_seen(backed.crust, samples);
    times.end();
    return is_better ? std::optional(std::move(best.sheets)) : std::nullopt;
}

} // namespace

bool may_lack_sheets(const Points& samples, const LabelledBalls& labelled, int threads)
{
    if (labelled.violated_votes <= suspicious_votes)
        return false;
    const TriangleMesh crust =
        triangulate_polygons(list_crust_polygons(labelled.regular, labelled.labels, threads), threads);
    return measure_missed_points(samples, crust, threads) > bearable_miss;
}

std::optional<BackedSheets> back_open_sheet(const Points& samples, const Vectors& normals, const LabelledBalls& closed,
                                            bool is_seen, const BallLabellingOptions& options, PhaseTimes& times,
                                            const Progress& progress)
{
    if (closed.violated_votes <= suspicious_votes)
        return {};
    times.begin("backs of sheets");
    const Found lidded = look_at(samples, closed, options.threads);
    if (!lidded.is_flat() && !lidded.lacks_much())
        return {};
    return back_all(samples, normals, lidded, is_seen, options_for_sheets(options), times, progress);
}

std::optional<BackedSheets> label_open_sheet(const Points& samples, const Vectors& normals,
                                             const BallLabellingOptions& usual_options, PhaseTimes& times,
                                             const Progress& progress)
{
    const BallLabellingOptions options = options_for_sheets(usual_options);
    LabelledBalls closed = label_polar_balls(samples, normals, options, times, progress.part(0, 0.4, "polar balls"));
    times.begin("backs of sheets");
    const Found lidded = look_at(samples, closed, options.threads);
    if (!lidded.is_whole() || lidded.handles > 0 || lidded.is_flat())
        if (std::optional<BackedSheets> slab =
                back_all(samples, normals, lidded, false, options, times, progress.part(0.4, 1, "polar balls")))
            return slab;
    times.end();
    if (!lidded.is_whole())
        return {};
    return BackedSheets{samples, normals, std::move(closed), 0, 0};
}

} // namespace recon
