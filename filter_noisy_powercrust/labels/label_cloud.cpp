#include "label_cloud.h"

#include "attempts.h"
#include "look_between_sheets.h"
#include "look_for_walls.h"

#include "filter_amls/mesh/label_points.h"
#include "filter_amls/mesh/open_sheets.h"
#include "filter_amls/mesh/thin_tubes.h"
#include "filter_amls/mesh/thin_walls.h"

#include <recon/bare_faces/bare_faces.h>
#include <recon/crust/back_sheets.h>
#include <recon/crust/weaving.h>
#include <recon/errors.h>
#include <recon/mesh/crust_mesh.h>
#include <recon/mesh/level_sheet.h>
#include <recon/mesh/mismatch.h>

#include <optional>
#include <utility>

namespace recon
{
namespace
{

/// Handles per sample above which lost sheets are lace, and share of them that backs may leave, or no more of them but
/// clearly fewer violated votes. Of a flooded crust or a ground the votes alone count.
constexpr double bearable_handles = 2e-4, whole_again = 0.5;
/// Share of the violated votes that backs may leave over a ground, with no more handles than before; all but some with
/// half of them.
constexpr double backed_ground = 0.75;

/// Noise below which an open sheet may be taken for exact [spacings]: coarse and rough ones read as noise, too.
constexpr double exact_below = 0.2;

/// That of a clean cloud, made once, where it is asked for.
class DenoisedAttempt
{
public:
    explicit DenoisedAttempt(Attempts& attempts) : attempts_(attempts), before_(attempts.known()) {}

    LabelledCloud& get(const Progress& progress)
    {
        if (made_)
            attempts_.restore(after_);
        else
        {
            made_ = attempts_.prepare_and_label(Denoise::on, attempts_.options.noise, progress);
            after_ = attempts_.known();
        }
        return *made_;
    }
    /// None where nothing is inside.
    LabelledCloud* find(const Progress& progress)
    {
        try
        {
            return &get(progress);
        }
        catch (const AlgorithmFailure&)
        {
            return nullptr;
        }
    }
    /// Others go on as if it had not been made.
    void set_aside() { attempts_.restore(before_); }

private:
    Attempts& attempts_;
    Attempts::Known before_, after_;
    std::optional<LabelledCloud> made_;
};

/// Which attempt stays, but for lost walls, see look_for_walls().
class CloudLabeller
{
public:
    explicit CloudLabeller(Attempts& attempts) : attempts_(attempts) {}

    /// As asked, or the points as they are, if they are thin tubes'.
    LabelledCloud make_first(const Progress& progress)
    {
        const SamplePreparationOptions& options = attempts_.options;
        const auto as_asked = [&](const Progress& part)
        { return attempts_.prepare_and_label(options.denoise, options.noise, part); };
        if (options.denoise != Denoise::automatic || options.noise > 0)
            return as_asked(progress);
        return label_unless_tubes([&] { return as_asked(progress.part(0, 0.8)); },
                                  [&](const std::optional<LabelledCloud>& first)
                                  { return label_tubes(first, progress.part(0.8, 1, "points as they are")); });
    }

    /// A clean cloud of thin walls, whose votes do not agree, with the normals of its AMLS surface.
    LabelledCloud orient_walls(LabelledCloud found, const Progress& progress)
    {
        if (found.cloud.denoised || found.completed > 0 || attempts_.points.size() > most_points_twice)
            return found;
        const auto list_normals = [&](const Progress& part) { return attempts_.list_clean_normals(found.cloud, part); };
        if (std::optional<LabelledBalls> better =
                label_thin_walls(found.cloud.samples, found.cloud.stacked, list_normals,
                                 attempts_.options_for(found.cloud), found.labelled, attempts_.times, progress))
        {
            found.labelled = std::move(*better);
            found.polygons.reset();
        }
        return found;
    }

    /// A clean cloud whose crust misses points, or weaves between them: as an open sheet, or denoised.
    LabelledCloud doubt_cleanness(LabelledCloud found, const Progress& progress)
    {
        if (found.labelled.violated_votes <= suspicious_votes)
            return found;
        std::optional<Judged> best = attempts_.judge(std::move(found));
        const WeavingSigns signs{best->attempt.labelled.violated_votes, best->handles};
        const bool misses_points = best->mismatch.missed_points > bearable_miss,
                   is_flooded = signs.violated > flooded_above, may_weave = may_weave_through_noise(signs);
        if (!misses_points && !is_flooded && !may_weave)
            return std::move(best->attempt);
        const bool may_have_both = attempts_.points.size() <= most_points_twice;
        DenoisedAttempt denoised(attempts_);
        const auto is_woven = [&](LabelledCloud& second)
        { return is_open(second.cloud) && weaves_through_noise(signs, list_signs(second)); };
        if (may_weave && may_have_both)
        {
            if (LabelledCloud* second = denoised.find(progress.part(0, 0.3, "second attempt"));
                second && is_woven(*second))
                return std::move(*second);
            denoised.set_aside();
        }
        if (misses_points)
            back_open_sheet(best->attempt, progress.part(0.3, 0.5));
        if (best->attempt.is_settled)
            return denoise_if_slab_misses(std::move(best->attempt), denoised, progress.part(0.5, 1));
        const double mismatch = best->mismatch.weighted_sum();
        if (!may_have_both)
            best.reset();
        LabelledCloud& second = denoised.get(progress.part(0.5, 0.6, "second attempt"));
        if (back_noisy_sheet(second, progress.part(0.6, 0.7)) || (!may_have_both && is_woven(second)))
            return std::move(second);
        if (const double left = second.labelled.violated_votes; left < signs.violated)
        {
            if (is_flooded)
                return std::move(second);
            if (Judged judged = attempts_.judge(std::move(second)); judged.mismatch.weighted_sum() < mismatch)
                return std::move(judged.attempt);
        }
        return best ? std::move(best->attempt) : make_first(progress.part(0.7, 1, "first attempt again"));
    }

    /// A noisy open sheet without a ground, with a back where it needs one. \returns whether it got one: then nothing
    /// else is wrong with it. Asked again of the same samples it says no.
    bool back_noisy_sheet(LabelledCloud& found, const Progress& progress)
    {
        if (!is_open(found.cloud) || found.completed > 0 || found.opened || attempts_.points.size() > most_points_twice)
            return false;
        if (std::exchange(asked_at_, found.cloud.noise) == found.cloud.noise)
            return false;
        if (LostSheets none; add_ground(found.cloud, none))
            return false;
        std::optional<BackedSheets> sheet = recon::back_open_sheet(
            found.cloud.samples, found.cloud.normals, found.labelled, !found.cloud.surface->report().seen_from.empty(),
            attempts_.usual_options_for(found.cloud), attempts_.times, progress);
        if (!sheet)
            return false;
        take(found, std::move(*sheet));
        found.is_settled = true;
        return true;
    }

    /// A scan whose sheets have the outside on both sides, with backs behind these.
    LabelledCloud back_lost_sheets(LabelledCloud found, const Progress& progress)
    {
        if (found.completed > 0 || back_noisy_sheet(found, progress))
            return found;
        // Where lids were opened the poles were sought along normals that have been turned since.
        LostSheets lost = find_lost_sheets(found.cloud.samples, found.labelled, found.cloud.denoised && !found.opened,
                                           attempts_.threads(), progress.part(0, 0));
        const bool has_ground = add_ground(found.cloud, lost);
        if (lost.share <= bearable_lost)
            return back_some_sheets(std::move(found), lost, progress);
        const WeavingSigns signs = list_signs(found);
        const bool is_lace = signs.handles > bearable_handles * double(found.cloud.samples.size());
        const double usual = found.cloud.denoised ? open_behind_with_normals : open_behind;
        const bool is_open_behind =
            may_be_a_sheet(lost, is_open(found.cloud), signs.violated) && signs.violated > usual;
        const bool is_whole_otherwise = !is_lace && signs.violated <= flooded_above && !has_ground;
        if (is_whole_otherwise && !is_open_behind)
            return back_some_sheets(std::move(found), lost, progress);
        if (is_lace)
            found.lost_sheets = lost.share;
        if (attempts_.options.denoise == Denoise::off || attempts_.points.size() > most_points_twice)
            return found;
        std::optional<LabelledCloud> slabs = label_slabs(found, lost, progress);
        if (!slabs)
            return found;
        const auto is_better = [&]
        {
            const double left = slabs->labelled.violated_votes;
            const auto has_at_most = [&](double most) { return list_signs(*slabs).handles <= most; };
            if (left <= clearly_backed * signs.violated)
                // Between a ground's samples are cracks rather than handles.
                return has_ground || (!is_lace && signs.violated > flooded_above) || has_at_most(signs.handles);
            if (!has_ground)
                return is_lace && has_at_most(whole_again * signs.handles);
            return left < signs.violated &&
                   has_at_most(left <= backed_ground * signs.violated ? signs.handles : whole_again * signs.handles);
        };
        if (is_better())
            return std::move(*slabs);
        return is_whole_otherwise ? back_some_sheets(std::move(found), lost, progress) : std::move(found);
    }

    /// With samples on faces that carry none, which other attempts took for ends of sheets or holes.
    LabelledCloud complete_bare_faces(LabelledCloud found, const Progress& progress)
    {
        if (attempts_.options.denoise == Denoise::off)
            return found;
        const PreparedSamples& doubted = found.cloud;
        const bool are_plain = doubted.denoised && doubted.given_noise == attempts_.options.noise &&
                               found.completed == 0 && found.backs == 0 && !found.opened;
        std::optional<PreparedSamples> cloud;
        const auto list_samples = [&]
        {
            const Denoise denoise = doubted.denoised ? Denoise::on : attempts_.options.denoise;
            cloud = are_plain
                        ? doubted
                        : attempts_.prepare(denoise, attempts_.options.noise, progress.part(0, 0.4, "preparation"));
            if (cloud->denoised)
                return SamplesOfFaces{{cloud->samples, cloud->normals}, is_open_sheet(*cloud->surface)};
            Vectors normals = attempts_.list_clean_normals(*cloud, progress.part(0.4, 0.5, "normals"));
            return SamplesOfFaces{{cloud->samples, std::move(normals)},
                                  is_open_sheet(attempts_.find_clean_surface(*cloud, {}))};
        };
        std::optional<LabelledBareFaces> faces = label_with_bare_faces(
            doubted.distinct.size(), found.labelled.violated_votes, list_samples,
            [&](const Points& samples, const Vectors& normals, double most_violated)
            {
                return label_polar_balls(samples, normals, attempts_.usual_options_for(*cloud).within(most_violated),
                                         attempts_.times, progress.part(0.6, 1, "polar balls"));
            },
            attempts_.times, attempts_.threads(), progress.part(0.5, 0.6));
        if (!faces)
            return found;
        cloud->samples = std::move(faces->samples);
        cloud->normals = std::move(faces->normals);
        LabelledCloud filled{std::move(*cloud), std::move(faces->labelled), faces->added};
        filled.has_filled_faces = true;
        return filled;
    }

private:
    /// A slab of exact points, unless it misses much, and one of denoised samples half of that at most.
    LabelledCloud denoise_if_slab_misses(LabelledCloud slab, DenoisedAttempt& denoised, const Progress& progress)
    {
        const double missed = measure_missed(slab);
        if (missed <= much_missed)
            return slab;
        LabelledCloud* found = denoised.find(progress.part(0, 0.5, "second attempt"));
        if (!found)
            return slab;
        LabelledCloud second = back_lost_sheets(std::move(*found), progress.part(0.5, 1, "backs of sheets"));
        second.is_settled = true;
        return second.backs > 0 && measure_missed(second) <= clearly_backed * missed ? std::move(second)
                                                                                     : std::move(slab);
    }

    static bool may_be_tubes(const LabelledCloud& first)
    {
        const PreparedSamples& cloud = first.cloud;
        return cloud.denoised && first.completed == 0 && cloud.distinct.size() <= most_points_twice &&
               recon::may_be_tubes(cloud.cleanness, cloud.is_doubtful, first.labelled.violated_votes);
    }

    /// The points as they are, if they are thin tubes'. \param first none if it failed.
    std::optional<LabelledCloud> label_tubes(const std::optional<LabelledCloud>& first, const Progress& progress)
    {
        if (first && !may_be_tubes(*first))
            return {};
        try
        {
            LabelledCloud exact = first ? attempts_.label_fine(first->cloud, most_violated_by_tubes, progress)
                                        : attempts_.label_fine(most_violated_by_tubes, progress);
            if (are_tubes(exact.labelled.violated_votes, first ? first->labelled.violated_votes : 1))
                return exact;
        }
        catch (const AlgorithmFailure&) // nothing is inside
        {
        }
        return {};
    }

    /// With backs behind all lost sheets, of samples that have normals. None if they get none.
    std::optional<LabelledCloud> label_slabs(const LabelledCloud& found, LostSheets lost, const Progress& progress)
    {
        PreparedSamples backed = found.cloud;
        if (!backed.denoised)
        {
            LabelledCloud oriented =
                attempts_.prepare_and_label(Denoise::on, attempts_.options.noise, progress.part(0, 0.5, "normals"));
            if (!oriented.cloud.denoised || oriented.completed > 0)
                return {};
            lost = find_lost_sheets(oriented.cloud.samples, oriented.labelled, true, attempts_.threads(),
                                    progress.part(0.5, 0.5));
            backed = std::move(oriented.cloud);
        }
        const int backs = back_sheets(lost, backed.samples, backed.normals, attempts_.threads());
        LabelledCloud slabs =
            attempts_.label(std::move(backed), BallLimit::local, progress.part(0.5, 1, "backs of sheets"));
        slabs.backs = backs;
        slabs.lost_sheets = lost.share;
        return slabs;
    }

    /// A clean cloud that is an open sheet, with a back where it needs one.
    void back_open_sheet(LabelledCloud& found, const Progress& progress)
    {
        PreparedSamples& cloud = found.cloud;
        if (found.completed > 0 || attempts_.points.size() > most_points_twice)
            return;
        const AmlsSurfaceReport report = attempts_.find_clean_surface(cloud, progress.part(0, 0.4)).report();
        if (!report.open || report.noise > exact_below * report.spacing)
            return;
        const Vectors normals = attempts_.list_clean_normals(cloud, progress.part(0.4, 0.5));
        if (LostSheets none; recon::add_ground(cloud.samples, normals, none, attempts_.threads()))
            return;
        if (std::optional<BackedSheets> sheet = label_open_sheet(
                cloud.samples, normals, attempts_.usual_options_for(cloud), attempts_.times, progress.part(0.5, 1)))
        {
            take(found, std::move(*sheet));
            found.is_settled = true;
        }
    }

    /// The same where nothing else is wrong: a wall whose hollow no view closed.
    LabelledCloud back_some_sheets(LabelledCloud found, const LostSheets& lost, const Progress& progress)
    {
        PreparedSamples& cloud = found.cloud;
        if (found.opened || attempts_.options.denoise == Denoise::off || cloud.samples.size() > most_points_twice)
            return found;
        const auto list_normals = [&](const Progress& part)
        { return cloud.denoised ? cloud.normals : attempts_.list_clean_normals(cloud, part); };
        if (std::optional<BackedSheets> backed =
                label_with_backs(lost, cloud.samples, cloud.denoised, list_normals, found.labelled,
                                 attempts_.usual_options_for(cloud), attempts_.times, progress))
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

    /// The ground of a scene is such a sheet, whatever the balls between its samples are called.
    bool add_ground(const PreparedSamples& cloud, LostSheets& lost) const
    {
        return is_open(cloud) && recon::add_ground(cloud.samples, cloud.normals, lost, attempts_.threads());
    }

    double measure_missed(LabelledCloud& found)
    {
        return measure_missed_points(found.cloud.distinct, attempts_.extract(found), attempts_.threads());
    }

    WeavingSigns list_signs(LabelledCloud& found)
    {
        return {found.labelled.violated_votes, measure_closed_topology(attempts_.extract(found)).genus()};
    }

    /// Whether it has normals, too.
    static bool is_open(const PreparedSamples& cloud) { return cloud.denoised && cloud.surface->report().open; }

    Attempts& attempts_;
    double asked_at_ = -1; ///< Noise of the samples that back_noisy_sheet() was last asked of.
};

} // namespace

namespace
{

/// The first attempt or one of those that are made where it is doubted.
LabelledCloud choose_attempt(Attempts& attempts, CloudLabeller& labeller, const Progress& progress)
{
    const SamplePreparationOptions& options = attempts.options;
    LabelledCloud first = labeller.make_first(progress.part(0, 0.7, "first attempt"));
    // Bare flats explain sheets without an inside, also where less noise took the place of completed ones.
    const bool has_bare_flats = first.cloud.denoised && first.completed > 0;
    if (!first.cloud.denoised && options.denoise == Denoise::automatic)
    {
        first = labeller.doubt_cleanness(std::move(first), progress.part(0.7, 0.8, "other attempts"));
        if (first.is_settled)
            return first;
        first = labeller.orient_walls(std::move(first), progress.part(0.8, 0.9, "thin walls"));
    }
    else if (first.cloud.denoised && options.noise == 0)
    {
        const Attempts::Known known = attempts.known();
        auto between = look_between_sheets(attempts, first, progress.part(0.7, 0.75, "more noise"));
        const Attempts::Known known_between = attempts.known();
        const bool is_settled = between && !between->has_lids;
        if (!is_settled)
        {
            attempts.restore(known);
            if (labeller.back_noisy_sheet(first, progress.part(0.75, 0.77, "backs of sheets")))
                return first;
            first = look_for_walls(attempts, std::move(first), progress.part(0.77, 0.9, "other attempts"));
        }
        if (between && !first.found_walls && !first.opened)
        {
            attempts.restore(known_between);
            first = std::move(between->attempt);
        }
    }
    if (has_bare_flats)
        return first;
    return labeller.back_lost_sheets(std::move(first), progress.part(0.9, 1, "lost sheets"));
}

} // namespace

LabelledCloud label_cloud(const Points& points, const SamplePreparationOptions& options,
                          const BallLabellingOptions& labelling, PhaseTimes& times, const Progress& progress)
{
    Attempts attempts(points, options, labelling, times);
    // A threshold of the user's that leaves no inner ball is no failure: normals would only dress it up.
    if (labelling.ball_threshold > 0)
        return attempts.prepare_and_label(options.denoise, options.noise, progress);
    CloudLabeller labeller(attempts);
    return labeller.complete_bare_faces(choose_attempt(attempts, labeller, progress.part(0, 0.95)),
                                        progress.part(0.95, 1, "bare faces"));
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
