#include "label_samples.h"

#include <recon/bare_faces/label_flats.h>
#include <recon/bare_faces/label_noisy_flats.h>

#include <utility>

namespace recon
{
namespace
{

/// Takes what was found on flat faces.
template <typename Flats>
void take_samples(LabelledCloud& found, Flats flats)
{
    found.cloud.samples = std::move(flats.samples);
    found.labelled = std::move(flats.labelled);
    found.completed = flats.added;
}

/// Exact points with their bare flat faces completed.
void complete_exact(LabelledCloud& found, const BallLabellingOptions& labelling, PhaseTimes& times,
                    const Progress& progress)
{
    PreparedSamples& cloud = found.cloud;
    std::optional<LabelledFlats> flats = label_with_flats(
        cloud.samples, [&] { return cloud.complete(times, labelling.threads, progress.part(0, 0.1, "flat faces")); },
        found.labelled.violated_votes, label_within(labelling, times, progress.part(0.1, 1, "polar balls")));
    if (flats)
        take_samples(found, std::move(*flats));
}

/// The same of denoised samples.
void complete_denoised(LabelledCloud& found, const BallLabellingOptions& labelling, PhaseTimes& times,
                       const Progress& progress)
{
    PreparedSamples& cloud = found.cloud;
    const DenoisedCloud denoised{cloud.distinct, cloud.noise / cloud.frame.scale(), cloud.samples, cloud.normals};
    std::optional<LabelledNoisyFlats> flats = label_with_noisy_flats(
        denoised, found.labelled, labelling.noise_taken,
        label_within(labelling, times, progress.part(0, 1, "polar balls")), found.polygons, times, labelling.threads);
    if (!flats)
        return;
    cloud.normals = std::move(flats->normals);
    found.polygons = std::move(flats->polygons);
    take_samples(found, std::move(*flats));
}

} // namespace

CrustPolygons& LabelledCloud::list_polygons(int threads)
{
    if (!polygons)
        polygons = list_crust_polygons(labelled.regular, labelled.labels, threads);
    return *polygons;
}

LabelledCloud label_samples(PreparedSamples cloud, const BallLabellingOptions& labelling, PhaseTimes& times,
                            const Progress& progress)
{
    LabelledBalls plain =
        label_polar_balls(cloud.samples, cloud.normals, labelling, times, progress.part(0, 0.6, "polar balls"));
    LabelledCloud found{std::move(cloud), std::move(plain)};
    if (found.labelled.violated_votes <= labelling.most_violated)
        (found.cloud.denoised ? complete_denoised : complete_exact)(found, labelling, times, progress.part(0.6, 1));
    return found;
}

} // namespace recon
