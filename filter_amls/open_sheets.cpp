#include "open_sheets.h"

#include <recon/block_search.h>
#include <recon/crust_mesh.h>
#include <recon/disjoint_sets.h>
#include <recon/mismatch.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace recon
{
namespace
{

/// Mean thickness below which the lid of what is as shallow as a saddle lies beside much of the sheet [spacings].
constexpr double thinnest_lidded = 7;
/// Share of samples that the crust of noisy ones misses where a sheet is lost, however deep the rest: 0.19 of a roll,
/// 0.005 of a scanned statue, whose back would take as long as all else.
constexpr double much_missed = 0.02;

/// Of a slab's second attempt [spacings].
constexpr double other_thickness = 4;
/// Above this a slab, which has twice as many and shares no balls, takes too much memory [samples].
constexpr std::size_t most_backed = 1'000'000;

/// A crust, and what it lacks of an open sheet.
struct Found
{
    TriangleMesh crust;
    LostSheets lost;
    double missed = 0; ///< Share of the samples [0..1].
    int handles = 0;
    double thickness = 0; ///< [spacings]

    bool is_whole() const { return lost.around.empty() && missed <= bearable_miss; }
    bool is_flat() const { return thickness < thinnest_lidded; }
    bool lacks_much() const { return missed > much_missed || lost.share > bearable_lost; }
};

Found look_at(const Points& samples, const LabelledBalls& labelled, int threads)
{
    Found found;
    found.crust = triangulate_polygons(list_crust_polygons(labelled.regular, labelled.labels, threads), threads);
    found.lost = find_lost_sheets(samples, labelled, true, threads);
    found.missed = measure_missed_points(samples, found.crust, threads);
    found.handles = measure_closed_topology(found.crust).genus();
    found.thickness = measure_thickness(found.crust) / labelled.spacing;
    return found;
}

/// Whether each connected part of a mesh is the nearest one of some sample.
bool is_all_seen(const TriangleMesh& mesh, const Points& samples)
{
    DisjointSets parts(mesh.vertices.size());
    for (const auto& t : mesh.triangles)
    {
        parts.join(t[0], t[1]);
        parts.join(t[0], t[2]);
    }
    const BlockSearch search(mesh.vertices);
    std::vector<char> is_seen(mesh.vertices.size(), 0);
    for (const Point& sample : samples)
        is_seen[std::size_t(parts.find(search.nearest(sample)))] = 1;
    return std::all_of(mesh.triangles.begin(), mesh.triangles.end(),
                       [&](const auto& t) { return is_seen[std::size_t(parts.find(t[0]))]; });
}

/// A sheet with a back behind all of it.
struct Slab
{
    BackedSheets sheets;
    Found found;
};

Slab make_slab(const Points& samples, const Vectors& normals, double thickness, const BallLabellingOptions& options,
               PhaseTimes& times, const Progress& progress)
{
    BallLabellingOptions unshared = options;
    unshared.share_balls = false; // at its rim a slab violates more votes than shared balls may
    const LostSheets all{std::vector<double>(samples.size(), 1), 1, 1};
    Points both = samples;
    Vectors both_normals = normals;
    const int backs = back_sheets(all, both, both_normals, options.threads, thickness);
    LabelledBalls labelled = label_polar_balls(both, both_normals, unshared, times, progress);
    times.begin("backs of sheets");
    Found found = look_at(samples, labelled, options.threads);
    return {{std::move(both), std::move(both_normals), std::move(labelled), backs, 1}, std::move(found)};
}

/// None if it is no better than what was closed by a lid.
std::optional<BackedSheets> back_all(const Points& samples, const Vectors& normals, const Found& lidded,
                                     const BallLabellingOptions& options, PhaseTimes& times, const Progress& progress)
{
    if (samples.size() > most_backed)
        return {};
    Slab best = make_slab(samples, normals, usual_thickness, options, times, progress.part(0, 0.6));
    // Gaps between random samples can be tunnels through it, but hardly through both.
    if (best.found.handles > 0)
        if (Slab other = make_slab(samples, normals, other_thickness, options, times, progress.part(0.6, 1));
            other.found.handles < best.found.handles)
            best = std::move(other);
    const Found& backed = best.found;
    const bool has_fewer_handles =
        backed.handles < lidded.handles || (lidded.is_flat() && backed.handles == lidded.handles);
    const bool is_better =
        backed.is_whole() && (!lidded.is_whole() || has_fewer_handles) && is_all_seen(backed.crust, samples);
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
                                            const BallLabellingOptions& options, PhaseTimes& times,
                                            const Progress& progress)
{
    if (closed.violated_votes <= suspicious_votes)
        return {};
    times.begin("backs of sheets");
    const Found lidded = look_at(samples, closed, options.threads);
    if (!lidded.is_flat() && !lidded.lacks_much())
        return {};
    return back_all(samples, normals, lidded, options, times, progress);
}

std::optional<BackedSheets> label_open_sheet(const Points& samples, const Vectors& normals,
                                             const BallLabellingOptions& options, PhaseTimes& times,
                                             const Progress& progress)
{
    LabelledBalls closed = label_polar_balls(samples, normals, options, times, progress.part(0, 0.4, "polar balls"));
    times.begin("backs of sheets");
    const Found lidded = look_at(samples, closed, options.threads);
    if (!lidded.is_whole() || lidded.handles > 0 || lidded.is_flat())
        if (std::optional<BackedSheets> slab =
                back_all(samples, normals, lidded, options, times, progress.part(0.4, 1, "polar balls")))
            return slab;
    times.end();
    if (!lidded.is_whole())
        return {};
    return BackedSheets{samples, normals, std::move(closed), 0, 0};
}

} // namespace recon
