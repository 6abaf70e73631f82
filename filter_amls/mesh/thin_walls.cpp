#include "thin_walls.h"

#include <recon/mesh/crust_mesh.h>

namespace recon
{
namespace
{

/// Share of samples with other sheets beside their own that calls for normals. Bores and holes of solid parts, which
/// normals close now and then, have up to 0.18.
constexpr double many_stacked = 0.25;
/// Share of violated votes below which no thin wall had a handle too many.
constexpr double undisputed_votes = 0.001;
/// Share of them that labels with normals may leave: 0.1 to 0.45 where handles went. And both shares if at most half
/// of the handles are left: 0.73 and 0.75 of the votes where louvres' and slots' false ones went.
constexpr double clearly_fewer = 0.5, fewer = 0.8, half_of_handles = 0.5;

int count_handles(const LabelledBalls& labelled, int threads)
{
    return measure_closed_topology(
               triangulate_polygons(list_crust_polygons(labelled.regular, labelled.labels, threads), threads))
        .genus();
}

} // namespace

std::optional<LabelledBalls> label_thin_walls(const Points& samples, double stacked,
                                              const std::function<Vectors(const Progress&)>& list_normals,
                                              const BallLabellingOptions& options, const LabelledBalls& found,
                                              PhaseTimes& times, const Progress& progress)
{
    if (stacked <= many_stacked || found.violated_votes <= undisputed_votes)
        return {};
    const int before = count_handles(found, options.threads);
    if (before == 0)
        return {};
    const Vectors normals = list_normals(progress.part(0, 0.5, "normals"));
    LabelledBalls labelled = label_polar_balls(samples, normals, options, times, progress.part(0.5, 1, "polar balls"));
    if (labelled.violated_votes > fewer * found.violated_votes)
        return {};
    const bool has_clearly_fewer = labelled.violated_votes <= clearly_fewer * found.violated_votes;
    const int after = count_handles(labelled, options.threads);
    if (after >= before || (!has_clearly_fewer && after > half_of_handles * before))
        return {};
    return labelled;
}

} // namespace recon
