#include "attempts.h"

#include "filter_amls/surface/sample_surface.h"

#include <algorithm>
#include <utility>

namespace recon
{
namespace
{

/// Share of samples with long Voronoi cells up to which shared balls would hardly do, see share_poles().
constexpr double well_sampled = 0.95;

} // namespace

PreparedSamples Attempts::prepare(Denoise denoise, double noise, const Progress& progress)
{
    SamplePreparationOptions chosen = options;
    chosen.denoise = denoise;
    chosen.noise = noise;
    return prepare_samples(points, chosen, latest_, times, progress);
}

LabelledCloud Attempts::prepare_and_label(Denoise denoise, double noise, const Progress& progress)
{
    PreparedSamples cloud = prepare(denoise, noise, progress.part(0, 0.35, "preparation"));
    known_.noise = std::max(known_.noise, cloud.noise);
    const BallLimit limit = limit_for(cloud);
    return label(std::move(cloud), limit, progress.part(0.35, 1, "labels"));
}

LabelledCloud Attempts::label_fine(double most_violated, const Progress& progress)
{
    SamplePreparationOptions as_they_are = options;
    as_they_are.denoise = Denoise::off;
    return label_fine(prepare_samples(points, as_they_are, latest_, times, {}), most_violated, progress);
}

LabelledCloud Attempts::label_fine(PreparedSamples cloud, double most_violated, const Progress& progress)
{
    if (cloud.outliers > cloud.isolated)
        cloud.choose_frame(points_at(cloud.order, points), points);
    cloud.samples = cloud.distinct;
    cloud.normals.clear();
    cloud.surface.reset();
    if (cloud.denoised)
    {
        cloud.completion.reset(); // on projected samples
        cloud.may_have_flats = false;
    }
    cloud.denoised = cloud.is_noisy = false;
    cloud.outliers = cloud.isolated;
    return label(std::move(cloud), BallLimit::fine, progress, most_violated);
}

LabelledCloud Attempts::label(PreparedSamples cloud, BallLimit limit, const Progress& progress, double most_violated)
{
    BallLabellingOptions labelling = options_for(cloud);
    labelling.limit = limit;
    labelling.most_violated = most_violated;
    LabelledCloud found = label_samples(std::move(cloud), labelling, times, progress);
    known_.is_sharing_disputed |=
        found.cloud.denoised && labelling.sharing == BallSharing::undisputed && !found.labelled.is_shared;
    return found;
}

TriangleMesh Attempts::extract(LabelledCloud& found)
{
    times.begin("mismatch");
    return triangulate_polygons(found.list_polygons(labelling_.threads), labelling_.threads);
}

Judged Attempts::judge(LabelledCloud attempt)
{
    Judged result{std::move(attempt), {}};
    const TriangleMesh crust = extract(result.attempt);
    result.mismatch = measure_mismatch(result.attempt.cloud.distinct, crust, labelling_.threads);
    result.handles = measure_closed_topology(crust).genus();
    return result;
}

const AmlsSurface& Attempts::find_clean_surface(const PreparedSamples& cloud, const Progress& progress)
{
    times.begin("AMLS");
    return latest_.find(points, points_at(cloud.order, points), options, progress);
}

Vectors Attempts::list_clean_normals(const PreparedSamples& cloud, const Progress& progress)
{
    const AmlsSurface& surface = find_clean_surface(cloud, progress.part(0, 0.6, "AMLS surface"));
    return list_surface_normals(points_at(cloud.order, points), surface, options.threads,
                                progress.part(0.6, 1, "normals"));
}

BallLabellingOptions Attempts::options_for(const PreparedSamples& cloud) const
{
    BallLabellingOptions result = labelling_;
    result.ball_threshold /= cloud.frame.scale();
    result.noise /= cloud.frame.scale();
    result.noise_taken = known_.noise / cloud.frame.scale();
    // A denoised cloud is sampled evenly. The crust of a clean one goes through the samples afterwards, as it must,
    // see share_poles().
    if (cloud.denoised ? known_.is_sharing_disputed : cloud.is_noisy || cloud.cleanness <= well_sampled)
        result.sharing = BallSharing::none;
    return result;
}

/// Of a clean cloud every ball counts, unless it is noisy in parts that the gate did not see.
BallLimit Attempts::limit_for(const PreparedSamples& cloud) const
{
    const bool is_clean = !cloud.denoised && !cloud.is_noisy;
    return is_clean && options.noise == 0 ? BallLimit::fewest_votes : BallLimit::local;
}

BallLabellingOptions Attempts::usual_options_for(const PreparedSamples& cloud) const
{
    BallLabellingOptions result = options_for(cloud);
    result.limit = limit_for(cloud);
    return result;
}

} // namespace recon
