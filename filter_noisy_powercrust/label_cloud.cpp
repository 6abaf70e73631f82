#include "label_cloud.h"

#include "filter_amls/open_sheets.h"
#include "filter_amls/sample_surface.h"
#include "filter_amls/thin_walls.h"

#include <recon/back_sheets.h>
#include <recon/crust_mesh.h>
#include <recon/level_sheet.h>
#include <recon/lids.h>
#include <recon/mismatch.h>
#include <recon/parallel.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace recon
{
namespace
{

// Limits of the attempts, in the order in which they are made, after that of a clean cloud, see bearable_miss. Each has
// a sign that calls for it, and a share of what speaks against the crust so far that it may keep: an attempt that keeps
// more balls fits any points better.

// A denoised cloud: balls by the spacing alone, less noise, then open lids.
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

// Sheets that have the outside on both sides: backs behind them.
/// Handles per sample above which lost sheets are lace, and share of them that backs may leave, or no more of them but
/// clearly fewer violated votes. Of a flooded crust or a ground the votes alone count.
constexpr double bearable_handles = 2e-4, whole_again = 0.5;

/// Above this number of points two attempts are not kept side by side [count].
constexpr std::size_t most_points_twice = 1'000'000;

/// Share of samples with long Voronoi cells up to which shared balls would hardly do, see share_poles().
constexpr double well_sampled = 0.95;

/// An attempt, and how far its crust and the points do not match.
struct Judged
{
    LabelledCloud attempt;
    Mismatch mismatch;

    bool has_lids() const { return mismatch.bare_area > bare_lid; }
};

/// Attempts at one cloud.
class Attempts
{
public:
    Attempts(const Points& points, const SamplePreparationOptions& options, const BallLabellingOptions& labelling,
             PhaseTimes& times)
        : points_(points), options_(options), labelling_(labelling), times_(times)
    {
    }

    /// \param noise standard deviation [length], 0 = estimate.
    LabelledCloud prepare_and_label(Denoise denoise, double noise, const Progress& progress)
    {
        SamplePreparationOptions options = options_;
        options.denoise = denoise;
        options.noise = noise;
        PreparedSamples cloud =
            prepare_samples(points_, options, latest_, times_, progress.part(0, 0.35, "preparation"));
        noise_ = std::max(noise_, cloud.noise);
        const BallLimit limit = limit_for(cloud);
        return label(std::move(cloud), limit, progress.part(0.35, 1, "labels"));
    }

    /// The points of an earlier attempt as they are, all balls kept by the spacing alone.
    LabelledCloud label_fine(PreparedSamples cloud, const Progress& progress)
    {
        if (cloud.outliers > cloud.isolated)
            cloud.choose_frame(points_at(cloud.order, points_), points_);
        cloud.samples = cloud.distinct;
        cloud.normals.clear();
        cloud.surface.reset();
        if (cloud.denoised)
            cloud.completion = {}; // on projected samples
        cloud.denoised = cloud.is_noisy = false;
        cloud.outliers = cloud.isolated;
        return label(std::move(cloud), BallLimit::fine, progress);
    }

    /// A clean cloud of thin walls, whose votes do not agree, with the normals of its AMLS surface.
    LabelledCloud orient_walls(LabelledCloud found, const Progress& progress)
    {
        if (found.cloud.denoised || found.completed > 0 || points_.size() > most_points_twice)
            return found;
        const auto list_normals = [&](const Progress& part) { return list_clean_normals(found.cloud, part); };
        if (std::optional<LabelledBalls> better =
                label_thin_walls(found.cloud.samples, found.cloud.stacked, list_normals, options_for(found.cloud),
                                 found.labelled, times_, progress))
        {
            found.labelled = std::move(*better);
            found.polygons.reset();
        }
        return found;
    }

    /// A denoised cloud whose crust has lost walls, denoised as if it had less noise.
    LabelledCloud look_for_walls(LabelledCloud first, const Progress& progress)
    {
        if (!may_have_lost_walls(first))
            return first;
        const bool has_flats = first.completed > 0;
        Judged best{std::move(first), {}};
        if (!lacks_walls(best))
            return std::move(best.attempt);
        if (best.attempt.cloud.is_doubtful && options_.denoise == Denoise::automatic)
            try_fine_balls(best, flooded_above, progress.part(0, 0.1, "fine balls"));
        if (best.has_lids())
        {
            const double finest = std::ldexp(best.attempt.cloud.noise, -halvings);
            LessNoise last = try_less_noise(best, progress.part(0.1, 0.7, "less noise"));
            // Bare flats are no lids. Votes that object little share balls, which have other numbers in the next run.
            if (!has_flats && best.has_lids() && last.violated > objecting_votes)
                try_open_lids(best,
                              last.dropped
                                  ? std::move(*last.dropped)
                                  : prepare_and_label(Denoise::on, finest, progress.part(0.7, 0.9, "least noise")),
                              progress.part(0.9, 1, "open lids"));
            if (best.has_lids())
                best.attempt.lost_walls = true;
        }
        return std::move(best.attempt);
    }

    /// A clean cloud whose crust misses points: as an open sheet, or denoised.
    LabelledCloud doubt_cleanness(LabelledCloud found, const Progress& progress)
    {
        const double violated = found.labelled.violated_votes;
        if (violated <= suspicious_votes)
            return found;
        std::optional<Judged> best = judge(std::move(found));
        const bool is_flooded = violated > flooded_above;
        if (best->mismatch.missed_points <= bearable_miss && !is_flooded)
            return std::move(best->attempt);
        if (best->mismatch.missed_points > bearable_miss)
            back_open_sheet(best->attempt, progress.part(0, 0.3));
        if (best->attempt.is_settled)
            return std::move(best->attempt);
        const double mismatch = best->mismatch.weighted_sum();
        if (points_.size() > most_points_twice)
            best.reset();
        {
            LabelledCloud second = prepare_and_label(Denoise::on, 0, progress.part(0.3, 0.7, "second attempt"));
            if (second.labelled.violated_votes < violated)
            {
                if (is_flooded)
                    return second;
                if (Judged judged = judge(std::move(second)); judged.mismatch.weighted_sum() < mismatch)
                    return std::move(judged.attempt);
            }
        }
        return best ? std::move(best->attempt)
                    : prepare_and_label(Denoise::automatic, 0, progress.part(0.7, 1, "first attempt again"));
    }

    /// A scan whose sheets have the outside on both sides, with backs behind these.
    LabelledCloud back_lost_sheets(LabelledCloud found, const Progress& progress)
    {
        if (found.completed > 0)
            return found;
        const int threads = labelling_.threads;
        // Where lids were opened the poles were sought along normals that have been turned since.
        LostSheets lost =
            find_lost_sheets(found.cloud.samples, found.labelled, found.cloud.denoised && !found.opened, threads);
        const bool has_ground = add_ground(found.cloud, lost);
        if (is_open(found.cloud) && !has_ground && !found.opened && points_.size() <= most_points_twice)
            if (std::optional<BackedSheets> sheet =
                    recon::back_open_sheet(found.cloud.samples, found.cloud.normals, found.labelled,
                                           usual_options_for(found.cloud), times_, progress))
            {
                take(found, std::move(*sheet));
                return found;
            }
        if (lost.share <= bearable_lost)
            return back_some_sheets(std::move(found), lost, progress);
        const double handles = measure_closed_topology(extract(found)).genus(),
                     violated = found.labelled.violated_votes;
        const bool is_lace = handles > bearable_handles * double(found.cloud.samples.size());
        const double usual = found.cloud.denoised ? open_behind_with_normals : open_behind;
        const bool is_open_behind = may_be_a_sheet(lost, is_open(found.cloud), violated) && violated > usual;
        const bool is_whole_otherwise = !is_lace && violated <= flooded_above && !has_ground;
        if (is_whole_otherwise && !is_open_behind)
            return back_some_sheets(std::move(found), lost, progress);
        if (is_lace)
            found.lost_sheets = lost.share;
        if (options_.denoise == Denoise::off || points_.size() > most_points_twice)
            return found;
        const LostSheets lost_before = lost;
        PreparedSamples backed = found.cloud;
        if (!backed.denoised)
        {
            LabelledCloud oriented = prepare_and_label(Denoise::on, options_.noise, progress.part(0, 0.5, "normals"));
            if (!oriented.cloud.denoised || oriented.completed > 0)
                return found;
            lost = find_lost_sheets(oriented.cloud.samples, oriented.labelled, true, threads);
            backed = std::move(oriented.cloud);
        }
        const int backs = back_sheets(lost, backed.samples, backed.normals, threads);
        LabelledCloud slabs = label(std::move(backed), BallLimit::local, progress.part(0.5, 1, "backs of sheets"));
        slabs.backs = backs;
        slabs.lost_sheets = lost.share;
        const bool has_fewer_violated = slabs.labelled.violated_votes <= clearly_backed * violated;
        const double most_handles = has_fewer_violated ? handles : whole_again * handles;
        // Between a ground's samples are cracks rather than handles.
        const bool votes_alone = has_ground || (!is_lace && violated > flooded_above);
        const bool is_better = (has_fewer_violated || (is_lace && !has_ground)) &&
                               (votes_alone || measure_closed_topology(extract(slabs)).genus() <= most_handles);
        if (is_better)
            return slabs;
        return is_whole_otherwise ? back_some_sheets(std::move(found), lost_before, progress) : std::move(found);
    }

private:
    /// A clean cloud that is an open sheet, with a back where it needs one.
    void back_open_sheet(LabelledCloud& found, const Progress& progress)
    {
        PreparedSamples& cloud = found.cloud;
        if (found.completed > 0 || points_.size() > most_points_twice)
            return;
        if (!find_clean_surface(cloud, progress.part(0, 0.4)).report().open)
            return;
        const Vectors normals = list_clean_normals(cloud, progress.part(0.4, 0.5));
        if (LostSheets none; recon::add_ground(cloud.samples, normals, none))
            return;
        if (std::optional<BackedSheets> sheet =
                label_open_sheet(cloud.samples, normals, usual_options_for(cloud), times_, progress.part(0.5, 1)))
        {
            take(found, std::move(*sheet));
            found.is_settled = true;
        }
    }

    /// The same where nothing else is wrong: a wall whose hollow no view closed.
    LabelledCloud back_some_sheets(LabelledCloud found, const LostSheets& lost, const Progress& progress)
    {
        PreparedSamples& cloud = found.cloud;
        if (found.opened || options_.denoise == Denoise::off || cloud.samples.size() > most_points_twice)
            return found;
        const auto list_normals = [&](const Progress& part)
        { return cloud.denoised ? cloud.normals : list_clean_normals(cloud, part); };
        if (std::optional<BackedSheets> backed =
                label_with_backs(lost, cloud.samples, cloud.denoised, list_normals, found.labelled,
                                 usual_options_for(cloud), times_, progress))
            take(found, std::move(*backed));
        return found;
    }

    static void take(LabelledCloud& found, BackedSheets backed)
    {
        found.cloud.samples = std::move(backed.samples);
        found.cloud.normals = std::move(backed.normals);
        found.labelled = std::move(backed.labelled);
        found.polygons.reset();
        found.backs = backed.backs;
        found.lost_sheets = backed.share;
    }

    /// The AMLS surface of a clean cloud's points, in its order.
    const AmlsSurface& find_clean_surface(const PreparedSamples& cloud, const Progress& progress)
    {
        times_.begin("AMLS");
        return latest_.find(points_at(cloud.order, points_), options_, progress);
    }

    Vectors list_clean_normals(const PreparedSamples& cloud, const Progress& progress)
    {
        const AmlsSurface& surface = find_clean_surface(cloud, progress.part(0, 0.6, "AMLS surface"));
        return list_surface_normals(points_at(cloud.order, points_), surface, options_.threads,
                                    progress.part(0.6, 1, "normals"));
    }

    /// The ground of a scene is such a sheet, whatever the balls between its samples are called.
    static bool add_ground(const PreparedSamples& cloud, LostSheets& lost)
    {
        return is_open(cloud) && recon::add_ground(cloud.samples, cloud.normals, lost);
    }

    /// Whether it has normals, too.
    static bool is_open(const PreparedSamples& cloud) { return cloud.denoised && cloud.surface->report().open; }

    TriangleMesh extract(LabelledCloud& found)
    {
        times_.begin("mismatch");
        return triangulate_polygons(found.list_polygons(labelling_.threads), labelling_.threads);
    }

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

    Judged judge(LabelledCloud attempt)
    {
        Judged result{std::move(attempt), {}};
        result.mismatch = measure_mismatch(result.attempt.cloud.distinct, extract(result.attempt), labelling_.threads);
        return result;
    }

    /// Whether a denoised crust has lids, seen from its samples, and points beside it as no noise lies. Measures the
    /// mismatch.
    bool lacks_walls(Judged& judged)
    {
        const PreparedSamples& cloud = judged.attempt.cloud;
        const TriangleMesh crust = extract(judged.attempt);
        judged.mismatch.bare_area = measure_bare_area(cloud.samples, crust, labelling_.threads);
        if (!judged.has_lids())
            return false;
        const bool has_flats = judged.attempt.completed > 0;
        if (!has_flats && lies_as_noise_does(cloud, crust))
            return false;
        judged.mismatch.missed_points = measure_missed_points(cloud.distinct, crust, labelling_.threads);
        return !has_flats || judged.mismatch.missed_points > missed_beside_flats;
    }

    bool lies_as_noise_does(const PreparedSamples& cloud, const TriangleMesh& crust) const
    {
        return measure_noise_misfit(points_at(cloud.claimed, cloud.distinct), crust, cloud.noise / cloud.frame.scale(),
                                    labelling_.threads)
            .is_noise();
    }

    /// Votes do not object to walls that are lost; where so many do the scene is open, and less noise makes lace of it.
    bool may_have_lost_walls(const LabelledCloud& first) const
    {
        return points_.size() <= most_points_twice && first.labelled.violated_votes <= flooded_above &&
               first.cloud.noise >= least_noise_of_walls * first.labelled.spacing * first.cloud.frame.scale();
    }

    /// \param highest_violation share of violated votes that the attempt must stay below.
    void try_fine_balls(Judged& best, double highest_violation, const Progress& progress)
    {
        Judged fine = judge(label_fine(best.attempt.cloud, progress));
        // Bare flats stay bare: there both are wrong, and the first less so.
        if (fine.attempt.labelled.violated_votes < highest_violation &&
            fine.mismatch.sum() < clearly_better * best.mismatch.sum())
            best = std::move(fine);
    }

    /// The last attempt with less noise: its share of violated votes, and what it found unless that is the best.
    struct LessNoise
    {
        double violated = 0;
        std::optional<LabelledCloud> dropped;
    };

    /// Half the noise, a quarter, an eighth, as long as that finds walls.
    LessNoise try_less_noise(Judged& best, const Progress& progress)
    {
        const bool has_flats = best.attempt.completed > 0;
        const double share = has_flats ? found_again_beside_flats : found_again;
        const double noise = best.attempt.cloud.noise, missed_before = best.mismatch.missed_points;
        LessNoise last;
        for (int i = 1; i <= halvings && best.has_lids(); ++i)
        {
            last.dropped.reset();
            Judged finer =
                judge(prepare_and_label(Denoise::on, std::ldexp(noise, -i),
                                        progress.part((i - 1.0) / halvings, double(i) / halvings, "less noise")));
            last.violated = finer.attempt.labelled.violated_votes;
            const double missed = finer.mismatch.missed_points;
            const bool is_hollow = finer.mismatch.bare_area <= bare_lid && missed < best.mismatch.missed_points;
            if (has_flats && !is_hollow && missed > hopeless * best.mismatch.missed_points)
                break;
            if ((is_hollow || missed < std::pow(share, i) * missed_before) && !lays_bare(finer.attempt, best.attempt))
                best = std::move(finer);
            else
                last.dropped = std::move(finer.attempt);
            if (missed > barely_less * missed_before)
                i = std::max(i, halvings - 1);
        }
        return last;
    }

    /// Whether faces that were completed are bare again, though less noise fits any points better.
    bool lays_bare(LabelledCloud& finer, LabelledCloud& best)
    {
        if (best.completed == 0)
            return false;
        const double before = lack(best), after = lack(finer);
        return after > laid_bare * before;
    }

    double lack(LabelledCloud& found)
    {
        const TriangleMesh crust = extract(found);
        return measure_lack(found.cloud, found.cloud.samples, crust, noise_ / found.cloud.frame.scale(),
                            labelling_.threads);
    }

    /// A cloud with all lids open.
    void try_open_lids(Judged& best, LabelledCloud open, const Progress& progress)
    {
        const double violated = open.labelled.violated_votes;
        if (open.completed > 0)
            return;
        std::optional<LabelledBalls> labelled = label_with_open_lids(
            open.cloud.samples, open.cloud.normals, open.labelled, options_for(open.cloud), times_, progress);
        if (!labelled)
            return;
        open.labelled = std::move(*labelled);
        open.polygons.reset();
        turn_normals(open);
        open.opened = true;
        Judged opened = judge(std::move(open));
        if (opened.attempt.labelled.violated_votes < clearly_fewer_votes * violated &&
            opened.mismatch.sum() < clearly_better * best.mismatch.sum())
            best = std::move(opened);
    }

    /// With lengths in units of the cloud's frame.
    BallLabellingOptions options_for(const PreparedSamples& cloud) const
    {
        BallLabellingOptions result = labelling_;
        result.ball_threshold /= cloud.frame.scale();
        result.noise /= cloud.frame.scale();
        result.noise_taken = noise_ / cloud.frame.scale();
        // A denoised cloud is sampled evenly. The crust of a clean one goes through the samples afterwards, as it must,
        // see share_poles().
        if (cloud.denoised ? is_sharing_disputed_ : cloud.is_noisy || cloud.cleanness <= well_sampled)
            result.sharing = BallSharing::none;
        return result;
    }

    /// Of a clean cloud every ball counts, unless it is noisy in parts that the gate did not see.
    BallLimit limit_for(const PreparedSamples& cloud) const
    {
        const bool is_clean = !cloud.denoised && !cloud.is_noisy;
        return is_clean && options_.noise == 0 ? BallLimit::fewest_votes : BallLimit::local;
    }

    BallLabellingOptions usual_options_for(const PreparedSamples& cloud) const
    {
        BallLabellingOptions result = options_for(cloud);
        result.limit = limit_for(cloud);
        return result;
    }

    LabelledCloud label(PreparedSamples cloud, BallLimit limit, const Progress& progress)
    {
        BallLabellingOptions labelling = options_for(cloud);
        labelling.limit = limit;
        LabelledCloud found = label_samples(std::move(cloud), labelling, times_, progress);
        is_sharing_disputed_ |=
            found.cloud.denoised && labelling.sharing == BallSharing::undisputed && !found.labelled.is_shared;
        return found;
    }

    const Points& points_;
    const SamplePreparationOptions& options_;
    const BallLabellingOptions& labelling_;
    PhaseTimes& times_;
    LatestSurface latest_;
    double noise_ = 0; ///< The most that was estimated or given so far; attempts that assume less do not have less.
    bool is_sharing_disputed_ = false; ///< Of samples of an earlier denoised attempt: those of the next would be, too.
};

} // namespace

LabelledCloud label_cloud(const Points& points, const SamplePreparationOptions& options,
                          const BallLabellingOptions& labelling, PhaseTimes& times, const Progress& progress)
{
    Attempts attempts(points, options, labelling, times);
    LabelledCloud first =
        attempts.prepare_and_label(options.denoise, options.noise, progress.part(0, 0.7, "first attempt"));
    // A threshold of the user's that leaves no inner ball is no failure: normals would only dress it up.
    if (labelling.ball_threshold > 0)
        return first;
    // Bare flats explain sheets without an inside, also where less noise took the place of completed ones.
    const bool has_bare_flats = first.cloud.denoised && first.completed > 0;
    if (!first.cloud.denoised && options.denoise == Denoise::automatic)
    {
        first = attempts.doubt_cleanness(std::move(first), progress.part(0.7, 0.8, "other attempts"));
        if (first.is_settled)
            return first;
        first = attempts.orient_walls(std::move(first), progress.part(0.8, 0.9, "thin walls"));
    }
    else if (first.cloud.denoised && options.noise == 0)
        first = attempts.look_for_walls(std::move(first), progress.part(0.7, 0.9, "other attempts"));
    if (has_bare_flats)
        return first;
    return attempts.back_lost_sheets(std::move(first), progress.part(0.9, 1, "lost sheets"));
}

std::string describe_lost_sheets(double share, int backs, Denoise denoise, std::size_t points)
{
    if (share <= 0)
        return {};
    if (backs > 0)
        return describe_backs(share);
    std::string text = describe_lost(share) + "They came out as lace: to see them whole, ";
    const bool is_off = denoise == Denoise::off, has_too_many = points > most_points_twice;
    if (is_off)
        text += "set denoise to automatic or on";
    if (has_too_many)
        text += std::string(is_off ? " and " : "") + "thin the points to a million, above which no back is tried";
    if (is_off || has_too_many)
        text += ", or ";
    return text + "select their points and reconstruct them apart from the rest (selected_only).";
}

} // namespace recon
