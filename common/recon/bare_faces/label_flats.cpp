#include <recon/bare_faces/label_flats.h>

#include <algorithm>
#include <utility>

namespace recon
{
namespace
{

/// Exact samples lie in a face's plane, so it also stays up to this share of violated votes, if no more are than
/// without it; walls between all rims only up to it: 0.001 to 0.012 where they were right, 0.018 to 0.22 where some
/// were not.
constexpr double certain_votes = 0.02;

/// Share of violated votes up to which no flat face is missing: at least 0.039 where one was, 0.0001 to 0.009 of
/// slices, each of whose outlines bounds a flat face, so that filling them all took ten times as long as the rest.
constexpr double calm_votes = 0.004;

} // namespace

std::optional<LabelledFlats> label_with_flats(const Points& samples, const std::function<FlatCompletion()>& complete,
                                              double violated, const LabelWithin& label)
{
    if (violated <= calm_votes)
        return {};
    const FlatCompletion completion = complete();
    std::optional<LabelledFlats> best;
    const auto attempt = [&](const Points& added, double bearable)
    {
        // So few that object do not ask for more samples than there are points.
        if (added.empty() || (violated <= certain_votes && added.size() > samples.size()))
            return;
        Points all = samples;
        all.insert(all.end(), added.begin(), added.end());
        LabelledBalls labelled = label(all, {}, bearable);
        if (labelled.violated_votes <= bearable)
            best = LabelledFlats{std::move(all), std::move(labelled), int(added.size())};
    };
    attempt(completion.points, std::max(std::min(certain_votes, violated), clearly_fewer_with_flats * violated));
    const double now = best ? best->labelled.violated_votes : violated;
    attempt(completion.with_all_walls, std::min({certain_votes, clearly_fewer_with_flats * now, violated}));
    return best;
}

} // namespace recon
