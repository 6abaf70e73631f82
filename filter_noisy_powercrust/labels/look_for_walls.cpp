#include "look_for_walls.h"

#include "filter_amls/mesh/open_sheets.h"
#include "filter_amls/mesh/thin_walls.h"

#include <recon/bare_faces/label_noisy_flats.h>
#include <recon/crust/lids.h>
#include <recon/mesh/mismatch.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace recon
{
namespace
{

// Limits of the attempts, in the order in which they are made. Each has a sign that calls for it, and a share of what
// speaks against the crust so far that it may keep: an attempt that keeps more balls fits any points better.

/// Share of points missed above which walls may be lost where faces were completed: what lies beside those that were
/// not found is not noise either.
constexpr double missed_beside_flats = 0.015;
/// Half the noise assumed leaves 0.45 to 0.8 of the points missed where they are missed by mere noise. Walls found
/// again leave less than a quarter; beside completed faces, where the second share is left, less noise still is not
/// worth its time.
constexpr double found_again = 0.25, hopeless = 0.45;
/// The same where faces were completed: what is laid bare has a say there as well.
constexpr double found_again_beside_flats = 0.35;
/// Less noise may lack so many times what completed faces leave bare or missed: 1.2 to 2.2 times where walls were found
/// again, seven and more where it merely lost the faces.
constexpr double laid_bare = 3;

class WallSearch
{
public:
    explicit WallSearch(Attempts& attempts) : attempts_(attempts) {}

    LabelledCloud run(LabelledCloud first, const Progress& progress)
    {
        if (!may_have_lost_walls(first))
            return first;
        const bool has_flats = first.completed > 0;
        Judged best{std::move(first), {}};
        if (!lacks_walls(best))
            return std::move(best.attempt);
        if (best.attempt.cloud.is_doubtful && attempts_.options.denoise == Denoise::automatic)
            try_fine_balls(best, flooded_above, progress.part(0, 0.1, "fine balls"));
        if (best.has_lids())
        {
            const double noise = best.attempt.cloud.noise;
            LessNoise last = try_less_noise(best, progress.part(0.1, 0.7, "less noise"));
            // Bare flats are no lids. Votes that object little share balls, which have other numbers in the next run.
            if (!has_flats && best.has_lids() && last.violated > objecting_votes)
                look_under_lids(best, last, noise, progress.part(0.7, 1));
            best.attempt.lost_walls = best.has_lids() && !last.finds_none;
        }
        return std::move(best.attempt);
    }

private:
    /// Normals of a filled cup's hollow point into the wall.
    static void turn_normals(LabelledCloud& found)
    {
        for (std::size_t i = 0; i < found.cloud.normals.size(); ++i)
        {
            const auto& [front, back] = found.labelled.kept.of_sample[i];
            if (front >= 0 && back >= 0 && found.labelled.labels[front] == Side::inner &&
                found.labelled.labels[back] == Side::outer)
                found.cloud.normals[i] *= -1;
        }
    }

    /// Whether a denoised crust has lids, seen from its samples, and votes object or points lie beside it as no noise
    /// does. Measures the mismatch.
    bool lacks_walls(Judged& judged)
    {
        const PreparedSamples& cloud = judged.attempt.cloud;
        const TriangleMesh crust = attempts_.extract(judged.attempt);
        judged.mismatch.bare_area = measure_bare_area(cloud.samples, crust, attempts_.threads());
        if (!judged.has_lids())
            return false;
        const bool has_flats = judged.attempt.completed > 0;
        if (!has_flats && judged.attempt.labelled.violated_votes <= objecting_votes && lies_as_noise_does(cloud, crust))
            return false;
        judged.mismatch.missed_points = measure_missed_points(cloud.distinct, crust, attempts_.threads());
        return !has_flats || judged.mismatch.missed_points > missed_beside_flats;
    }

    bool lies_as_noise_does(const PreparedSamples& cloud, const TriangleMesh& crust) const
    {
        if (cloud.surface && cloud.surface->report().has_only_lattice_noise())
            return true;
        return measure_noise_misfit(points_at(cloud.claimed, cloud.distinct), crust, cloud.noise / cloud.frame.scale(),
                                    attempts_.threads())
            .is_noise();
    }

    /// Where so many votes object the scene is open, and less noise makes lace of it.
    bool may_have_lost_walls(const LabelledCloud& first) const
    {
        return attempts_.points.size() <= most_points_twice && first.labelled.violated_votes <= flooded_above &&
               first.cloud.noise >= least_noise_of_walls * first.labelled.spacing * first.cloud.frame.scale();
    }

    /// \param highest_violation share of violated votes that the attempt must stay below.
    void try_fine_balls(Judged& best, double highest_violation, const Progress& progress)
    {
        LabelledCloud labelled = attempts_.label_fine(best.attempt.cloud, highest_violation, progress);
        if (labelled.labelled.violated_votes >= highest_violation)
            return;
        Judged fine = attempts_.judge(std::move(labelled));
        // Bare flats stay bare: there both are wrong, and the first less so.
        if (fine.mismatch.sum() < clearly_better * best.mismatch.sum())
            best = std::move(fine);
    }

    /// The last attempt with less noise: its share of violated votes, what it found unless that is the best, and
    /// whether it tells that no other will find walls.
    struct LessNoise
    {
        double violated = 0;
        std::optional<LabelledCloud> dropped = {};
        bool finds_none = false;
    };

    /// Half the noise, a quarter, an eighth, as long as that finds walls.
    LessNoise try_less_noise(Judged& best, const Progress& progress)
    {
        const bool has_flats = best.attempt.completed > 0;
        const double share = has_flats ? found_again_beside_flats : found_again;
        const double noise = best.attempt.cloud.noise, missed_before = best.mismatch.missed_points;
        const PointsAgainst before{missed_before, best.attempt.labelled.violated_votes};
        LessNoise last;
        for (int i = 1; i <= halvings && best.has_lids(); ++i)
        {
            last.dropped.reset();
            Judged finer = attempts_.judge(
                attempts_.prepare_and_label(Denoise::on, std::ldexp(noise, -i),
                                            progress.part((i - 1.0) / halvings, double(i) / halvings, "less noise")));
            last.violated = finer.attempt.labelled.violated_votes;
            const double missed = finer.mismatch.missed_points;
            const bool is_hollow = finer.mismatch.bare_area <= bare_lid && missed < best.mismatch.missed_points;
            const bool has_better_flats = has_flats && completes_more(finer, best);
            if (has_flats && !is_hollow && !has_better_flats && missed > hopeless * best.mismatch.missed_points)
                break;
            if (has_better_flats ||
                ((is_hollow || missed < std::pow(share, i) * missed_before) && !lays_bare(finer, best)))
            {
                best = std::move(finer);
                best.attempt.found_walls = true;
            }
            else
                last.dropped = std::move(finer.attempt);
            last.finds_none = best.has_lids() && finds_no_walls(before, {missed, last.violated});
            if (last.finds_none)
                break;
            if (missed > barely_less * missed_before)
                i = std::max(i, halvings - 1);
        }
        return last;
    }

    /// Whether faces that were completed are bare again, though less noise fits any points better.
    bool lays_bare(Judged& finer, Judged& best)
    {
        if (best.attempt.completed == 0)
            return false;
        const double before = lack(best), after = lack(finer);
        return after > laid_bare * before;
    }

    /// Whether other faces were completed, which lack clearly less and contradict no more votes.
    bool completes_more(Judged& finer, Judged& best)
    {
        return finer.attempt.completed > 0 &&
               finer.attempt.labelled.violated_votes <= best.attempt.labelled.violated_votes &&
               lack(finer) < clearly_better * lack(best);
    }

    /// Measured once.
    double lack(Judged& judged)
    {
        if (judged.lack)
            return *judged.lack;
        LabelledCloud& found = judged.attempt;
        const TriangleMesh crust = attempts_.extract(found);
        judged.lack = measure_lack(found.cloud.distinct, found.cloud.samples, crust,
                                   attempts_.noise() / found.cloud.frame.scale(), attempts_.threads());
        return *judged.lack;
    }

    /// The cloud with the least noise and open lids, or first, where none would find walls, the one that said so.
    /// \param noise told.
    void look_under_lids(Judged& best, LessNoise& last, double noise, const Progress& progress)
    {
        const double most_left = clearly_better * best.mismatch.sum();
        if (last.dropped)
            try_open_lids(best, std::move(*last.dropped), most_left, progress.part(0, 0.2, "open lids"));
        const bool are_there_after_all = last.finds_none && best.attempt.opened;
        if (are_there_after_all || (!last.finds_none && !last.dropped))
            try_open_lids(best,
                          attempts_.prepare_and_label(Denoise::on, std::ldexp(noise, -halvings),
                                                      progress.part(0.2, 0.7, "least noise")),
                          most_left, progress.part(0.7, 1, "open lids"));
    }

    /// A cloud with all lids open. \param most_mismatch that it must stay below.
    void try_open_lids(Judged& best, LabelledCloud open, double most_mismatch, const Progress& progress)
    {
        if (open.completed > 0)
            return;
        std::optional<LabelledBalls> labelled =
            label_with_open_lids(open.cloud.samples, open.cloud.normals, open.labelled,
                                 attempts_.options_for(open.cloud), attempts_.times, progress);
        if (!labelled)
            return;
        open.labelled = std::move(*labelled);
        open.polygons.reset();
        turn_normals(open);
        open.opened = true;
        Judged opened = attempts_.judge(std::move(open));
        if (opened.mismatch.sum() < most_mismatch)
            best = std::move(opened);
    }

    Attempts& attempts_;
};

} // namespace

LabelledCloud look_for_walls(Attempts& attempts, LabelledCloud first, const Progress& progress)
{
    return WallSearch(attempts).run(std::move(first), progress);
}

} // namespace recon
