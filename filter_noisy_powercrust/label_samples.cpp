#include "label_samples.h"

#include "complete_noisy_flats.h"

#include <recon/label_flats.h>
#include <recon/mismatch.h>

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

namespace recon
{
namespace
{

/// Up to the first share of violated votes a denoised cloud is not searched for bare faces, up to the second only if
/// its crust is bare somewhere: a plate with samples on its rims and bores may come out filled with few objections.
constexpr double calm_votes = 0.001, calm_votes_of_whole = 0.005;
/// Widths of the slabs in which planes are sought, in turns, while the votes refuse the completed crust or it is bare
/// or in pieces [1 = by the noise]. Rims with a bevel of one or two sigma fit one of these better; which, the bare area
/// tells.
constexpr double slab_widths[] = {1, 1.1, 1.35};
/// Share of the lack that other slabs may leave.
constexpr double clearly_less = 0.5;

/// A cloud's samples with those on bare flat faces, which come last.
struct Completion
{
    Points samples;
    Vectors normals;
    int added = 0; ///< [count]
};

/// Their labels, and what the crust still lacks.
struct CompletedFlats
{
    Completion completion;
    LabelledBalls labelled;
    std::optional<CrustPolygons> polygons = {}; ///< If judged.
    double lack = 0;                            ///< See measure_lack().
    int bodies = 1;

    bool is_whole() const { return lack <= bare_lid && bodies == 1; }
    bool is_better_than(const CompletedFlats& other) const
    {
        if (bodies != other.bodies)
            return bodies < other.bodies && lack <= std::max(bare_lid, other.lack);
        return lack < clearly_less * other.lack;
    }
};

/// The cloud's samples and the added ones, without those that these replace. \param is_replaced per sample of the
/// cloud.
Completion join(const PreparedSamples& cloud, const Points& added, const Vectors& normals,
                const std::vector<char>& is_replaced)
{
    Completion result;
    result.added = int(added.size());
    for (std::size_t i = 0; i < cloud.samples.size(); ++i)
        if (!is_replaced[i])
        {
            result.samples.push_back(cloud.samples[i]);
            if (cloud.denoised)
                result.normals.push_back(cloud.normals[i]);
        }
    result.samples.insert(result.samples.end(), added.begin(), added.end());
    result.normals.insert(result.normals.end(), normals.begin(), normals.end());
    return result;
}

/// Puts samples on bare flat faces in the place of those around their rims. None if there are none. \param width of the
/// slabs in which faces are sought [1 = by the standard deviation of the noise].
std::optional<Completion> complete(const PreparedSamples& cloud, double width, PhaseTimes& times, int threads)
{
    times.begin("flat faces");
    const NoisyFlatCompletion flats = complete_noisy_flats(cloud.distinct, width * cloud.noise / cloud.frame.scale(),
                                                           cloud.samples, cloud.normals, threads);
    return flats.points.empty() ? std::nullopt
                                : std::optional(join(cloud, flats.points, flats.normals, flats.is_replaced));
}

void judge(CompletedFlats& flats, const PreparedSamples& cloud, double noise, int threads)
{
    flats.polygons = list_crust_polygons(flats.labelled.regular, flats.labelled.labels, threads);
    const TriangleMesh crust = triangulate_polygons(*flats.polygons, threads);
    flats.lack = measure_lack(cloud, flats.completion.samples, crust, noise, threads);
    flats.bodies = measure_closed_topology(crust).components;
}

using Label = std::function<LabelledBalls(const Points& samples, const Vectors& normals)>;

std::optional<CompletedFlats> complete_exact(PreparedSamples& cloud, const LabelledBalls& plain, const Label& label,
                                             PhaseTimes& times, int threads, const Progress& progress)
{
    std::optional<LabelledFlats> found = label_with_flats(
        cloud.samples, [&] { return cloud.complete(times, threads, progress); }, plain.violated_votes,
        [&](const Points& samples) { return label(samples, {}); });
    if (!found)
        return {};
    return CompletedFlats{{std::move(found->samples), {}, found->added}, std::move(found->labelled)};
}

/// In slabs of several widths.
std::optional<CompletedFlats> complete_noisy(const PreparedSamples& cloud, const LabelledBalls& plain,
                                             const BallLabellingOptions& labelling, const Label& label,
                                             PhaseTimes& times)
{
    std::optional<CompletedFlats> best;
    for (const double width : slab_widths)
    {
        std::optional<Completion> completion = complete(cloud, width, times, labelling.threads);
        if (!completion)
            break;
        LabelledBalls labelled = label(completion->samples, completion->normals);
        // Where faces are bare most samples are on them. A few facets of a coarse model, that the votes do not want,
        // are no better in other slabs.
        if (!best && labelled.violated_votes > plain.violated_votes && completion->added < int(cloud.samples.size()))
            break;
        CompletedFlats flats{std::move(*completion), std::move(labelled)};
        if (flats.labelled.violated_votes <= clearly_fewer_with_flats * plain.violated_votes)
        {
            times.begin("mismatch");
            judge(flats, cloud, labelling.noise_taken, labelling.threads);
            if (!best || flats.is_better_than(*best))
                best = std::move(flats);
        }
        // Slabs of another width may show what is missing, or leave out a face that is none.
        if (best && best->is_whole())
            break;
    }
    return best;
}

} // namespace

CrustPolygons& LabelledCloud::list_polygons(int threads)
{
    if (!polygons)
        polygons = list_crust_polygons(labelled.regular, labelled.labels, threads);
    return *polygons;
}

double measure_lack(const PreparedSamples& cloud, const Points& samples, const TriangleMesh& crust, double noise,
                    int threads)
{
    const double bare = measure_bare_area(samples, crust, threads);
    return bare <= bare_lid ? bare : bare + measure_missed_points(cloud.distinct, crust, threads, {}, noise);
}

LabelledCloud label_samples(PreparedSamples cloud, const BallLabellingOptions& labelling, PhaseTimes& times,
                            const Progress& progress)
{
    const auto label = [&](const Points& samples, const Vectors& normals, double from, double to)
    { return label_polar_balls(samples, normals, labelling, times, progress.part(from, to, "polar balls")); };
    LabelledBalls plain = label(cloud.samples, cloud.normals, 0, 0.6);
    if (plain.violated_votes > labelling.most_violated ||
        (cloud.denoised && (plain.violated_votes <= calm_votes || !(cloud.noise > 0))))
        return {std::move(cloud), std::move(plain)};
    if (cloud.denoised && plain.violated_votes <= calm_votes_of_whole)
    {
        times.begin("mismatch");
        CrustPolygons polygons = list_crust_polygons(plain.regular, plain.labels, labelling.threads);
        const bool is_bare = measure_bare_area(cloud.distinct, triangulate_polygons(polygons, labelling.threads),
                                               labelling.threads) > bare_lid;
        if (!is_bare)
        {
            LabelledCloud whole{std::move(cloud), std::move(plain)};
            whole.polygons = std::move(polygons);
            return whole;
        }
    }
    const Label label_completed = [&](const Points& samples, const Vectors& normals)
    { return label(samples, normals, 0.65, 1); };
    std::optional<CompletedFlats> best = cloud.denoised
                                             ? complete_noisy(cloud, plain, labelling, label_completed, times)
                                             : complete_exact(cloud, plain, label_completed, times, labelling.threads,
                                                              progress.part(0.6, 0.65, "flat faces"));
    if (!best)
        return {std::move(cloud), std::move(plain)};
    cloud.samples = std::move(best->completion.samples);
    cloud.normals = std::move(best->completion.normals);
    LabelledCloud result{std::move(cloud), std::move(best->labelled), best->completion.added};
    result.polygons = std::move(best->polygons);
    return result;
}

} // namespace recon
