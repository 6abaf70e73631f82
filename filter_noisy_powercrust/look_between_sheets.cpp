#include "look_between_sheets.h"

#include <recon/crust_mesh.h>
#include <recon/errors.h>
#include <recon/mismatch.h>
#include <recon/weaving.h>

#include <cmath>
#include <iterator>
#include <utility>

namespace recon
{
namespace
{

/// An attempt whose crust may weave, in input units.
struct MaybeWoven
{
    Woven crust;
    bool looks_open = false;
    Points samples, claimed;
};

/// \param samples of the attempt with the least noise: the others have fewer, and lids of theirs are not bare.
Woven describe_crust(Attempts& attempts, LabelledCloud& found, const Points& samples)
{
    const TriangleMesh crust = attempts.extract(found);
    const UnitFrame& frame = found.cloud.frame;
    return {found.labelled.violated_votes, measure_volume(crust) * std::pow(frame.scale(), 3),
            measure_closed_topology(crust).genus(),
            measure_bare_area(frame.to_unit(samples), crust, attempts.threads())};
}

std::optional<BetweenSheets> label_between_sheets(Attempts& attempts, double noise, const MaybeWoven& first,
                                                  const Progress& progress)
{
    try
    {
        LabelledCloud wide = attempts.prepare_and_label(Denoise::on, noise, progress);
        const UnitFrame& frame = wide.cloud.frame;
        const Woven with_more = describe_crust(attempts, wide, first.samples);
        const NoiseMisfit misfit = measure_noise_misfit(frame.to_unit(first.claimed), attempts.extract(wide),
                                                        noise / frame.scale(), attempts.threads());
        if (wide.completed > 0 || wide.cloud.surface->report().open ||
            !lies_between_sheets(first.crust, with_more, misfit))
            return {};
        wide.is_between_sheets = true;
        return BetweenSheets{std::move(wide), !first.looks_open && with_more.bare_area > bare_lid};
    }
    catch (const AlgorithmFailure&) // nothing is inside
    {
        return {};
    }
}

} // namespace

std::optional<BetweenSheets> look_between_sheets(Attempts& attempts, LabelledCloud& first, const Progress& progress)
{
    const PreparedSamples& cloud = first.cloud;
    if (first.completed > 0 || attempts.points.size() > most_points_twice ||
        !may_weave(first.labelled.violated_votes, cloud.noise / cloud.frame.scale() / first.labelled.spacing))
        return {};
    MaybeWoven woven{{}, cloud.surface->report().open, cloud.samples, points_at(cloud.claimed, cloud.distinct)};
    for (Points* points : {&woven.samples, &woven.claimed})
        cloud.frame.from_unit_in_place(*points);
    woven.crust = describe_crust(attempts, first, woven.samples);
    if (woven.looks_open && woven.crust.bare_area > bare_if_open)
        return {};
    constexpr int most = int(std::size(reach_over_sheets));
    for (int i = 0; i < most; ++i)
        if (auto between = label_between_sheets(attempts, reach_over_sheets[i] * cloud.noise, woven,
                                                progress.part(double(i) / most, (i + 1.0) / most)))
            return between;
    return {};
}

} // namespace recon
