#include "look_between_sheets.h"

#include <recon/crust/weaving.h>
#include <recon/errors.h>
#include <recon/mesh/mismatch.h>

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

/// \param crust in the unit frame of what was found.
Woven describe_in_input_units(const LabelledCloud& found, const TriangleMesh& crust, const Points& samples, int threads)
{
    const UnitFrame& frame = found.cloud.frame;
    Woven result = describe_woven(found.labelled.violated_votes, crust, frame.to_unit(samples), threads);
    result.volume *= std::pow(frame.scale(), 3);
    return result;
}

std::optional<BetweenSheets> label_between_sheets(Attempts& attempts, double noise, const MaybeWoven& first,
                                                  const Progress& progress)
{
    try
    {
        LabelledCloud wide = attempts.prepare_and_label(Denoise::on, noise, progress);
        if (wide.completed > 0 || wide.cloud.surface->report().open)
            return {};
        const UnitFrame& frame = wide.cloud.frame;
        const TriangleMesh crust = attempts.extract(wide);
        const Woven with_more = describe_in_input_units(wide, crust, first.samples, attempts.threads());
        if (!lies_between_sheets(
                first.crust, with_more,
                measure_noise_misfit(frame.to_unit(first.claimed), crust, noise / frame.scale(), attempts.threads())))
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
    woven.crust = describe_in_input_units(first, attempts.extract(first), woven.samples, attempts.threads());
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
