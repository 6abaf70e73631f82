#include "prepare_input.h"

#include "filter_pn_refine/additions/fold_samples.h"
#include "filter_pn_refine/additions/hole_filling.h"
#include "filter_pn_refine/additions/void_samples.h"
#include "filter_pn_refine/creases/crease_detection.h"
#include "filter_pn_refine/samples/normal_noise.h"
#include "filter_pn_refine/samples/normal_repair.h"
#include "filter_pn_refine/step/sample_surface.h"
#include "filter_pn_refine/step/spacing.h"

#include <recon/errors.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace recon::pn
{
namespace
{

std::string count_of(int n, const std::string& one, const std::string& many)
{
    return std::to_string(n) + " " + (n == 1 ? one : many);
}

class Preparation
{
public:
    Preparation(const OrientedSamples& input, const PnRefineOptions& options, const PnRefineHints& hints,
                const UnitFrame& frame, int threads, Prepared& prepared, PnRefinement& result)
        : input_(input), options_(options), hints_(hints), frame_(frame), threads_(threads), prepared_(prepared),
          usable_(prepared.usable), result_(result)
    {
    }

    void run(const Progress& progress, PhaseTimes& times)
    {
        const double share_of_holes = options_.hole_radius > 0 ? 1.5 : 0; // they take longer than all else
        double begin = 0;
        const auto next = [&](double share, const std::string& phase)
        {
            const double end = begin + share / (1 + share_of_holes);
            return progress.part(std::exchange(begin, end), end, phase);
        };
        times.begin("prepare");
        choose(next(0.2, "choosing points"));
        if (options_.repair_normals)
            repair(next(0.15, "normals"));
        if (contradiction_of_normals(usable_) > much_contradiction)
            result_.warnings.push_back("The normals contradict the points around most of them. Either the points are "
                                       "noisy: move them with 'MLS projection (AMLS)' first. Or the normals are a "
                                       "mesh's, interpolated over large triangles: take those of faces, or remove "
                                       "them, then they are computed from the points.");
        times.begin("radii");
        update_spacing();
        if (options_.detect_creases)
            put_onto_creases(next(0.15, "creases"));
        find_fans(next(0.25, "radii"));
        if (options_.preserve_creases &&
            std::find(usable_.is_crease.begin(), usable_.is_crease.end(), char(1)) != usable_.is_crease.end())
            prepared_.mouths = std::make_unique<Mouths>(usable_, prepared_.spacing, threads_, next(0.05, "mouths"));
        if (options_.hole_radius > 0)
            put_into_holes(next(share_of_holes, "holes"));
        // Voids and folds are no end in themselves: they serve the steps.
        if (options_.fast || options_.steps == 0)
            return;
        prepared_.slack = slack_of_gradients(estimate_normal_noise(usable_));
        put_into_voids(next(0.05, "voids"));
        // Twice: what the first pass made shows the way to more.
        if (put_into_folds(next(0.1, "folds")))
            put_into_folds(next(0.05, "folds"));
    }

private:
    void choose(const Progress& progress)
    {
        choose_usable_samples(input_, hints_.is_isolated, frame_, crease_angle(), threads_, progress, usable_);
        const auto warn = [&](int n, const std::string& one, const std::string& many)
        {
            if (n > 0)
                result_.warnings.push_back(count_of(n, one, many) + " took no part.");
        };
        for (std::size_t i = 0; i < usable_.input.size() && !hints_.is_refined.empty(); ++i)
            usable_.is_frozen[i] = !hints_.is_refined[std::size_t(usable_.input[i])];
        warn(usable_.without_normal, "point has no normal and", "points have no normal and");
        warn(usable_.duplicates, "duplicate point", "duplicate points");
        warn(usable_.isolated, "isolated point", "isolated points");
        result_.left_out = usable_.without_normal + usable_.duplicates + usable_.isolated;
        if (usable_.input.empty())
            throw InvalidInput("No point has a normal: compute normals first.");
    }

    void repair(const Progress& progress)
    {
        for (int i :
             turn_contradicting_normals(usable_.samples, usable_.nearest, usable_.is_frozen, threads_, progress))
            result_.turned_normals.push_back(usable_.input[std::size_t(i)]);
        std::sort(result_.turned_normals.begin(), result_.turned_normals.end());
        if (!result_.turned_normals.empty())
            result_.warnings.push_back(count_of(int(result_.turned_normals.size()), "normal was", "normals were") +
                                       " turned over, since most neighbours contradict.");
    }

    void put_onto_creases(const Progress& progress)
    {
        const AddedSamples creases =
            detect_creases(usable_, prepared_.spacing, crease_angle(), threads_, progress.part(0, 0.6));
        if (!may_put_in(creases))
            return;
        result_.crease_points = put_in(creases, true);
        update_nearest(usable_, threads_, progress.part(0.6, 1));
        update_spacing();
    }

    void put_into_holes(const Progress& progress)
    {
        PnRefineOptions options;
        options.preserve_boundaries = options.preserve_creases = options.repair_normals = false;
        options.max_points = options_.max_points;
        options.threads = threads_;
        const auto refine = [&](const OrientedSamples& samples, int steps, const Progress& part)
        {
            options.steps = steps;
            // Its phases would look as if all began anew.
            PnRefinement r = refine_points(samples, options, {},
                                           Progress(
                                               [&](double fraction, const std::string&)
                                               {
                                                   part.report(fraction);
                                                   return true;
                                               }));
            return Refined{std::move(r.points), std::move(r.normals), std::move(r.parents)};
        };
        const FilledHoles holes =
            fill_holes(usable_, prepared_.fans, prepared_.spacing, options_.boundary_angle * radians,
                       options_.hole_radius / frame_.scale(), refine, threads_, progress.part(0, 0.9));
        result_.hole_points = put_in_if_allowed(holes.added, progress.part(0.9, 1));
        if (!holes.added.samples.points.empty() && result_.hole_points == 0)
            result_.warnings.push_back("No hole was filled: that would make more points than the largest number "
                                       "allowed (" +
                                       std::to_string(options_.max_points) + ").");
        else if (holes.too_wide > 0)
            result_.warnings.push_back(count_of(holes.too_wide, "hole is", "holes are") +
                                       " wider than the hole radius and stayed open.");
        else if (holes.has_rims && result_.hole_points == 0)
            result_.warnings.push_back("No hole was filled: between the rims there is none that is both at least some "
                                       "two spacings of the points and at most the hole radius in radius.");
    }

    void put_into_voids(const Progress& progress)
    {
        // Who gives a radius says how wide a void is that has to stay.
        if (options_.initial_radius > 0 || options_.target_radius > 0)
            return;
        result_.void_points =
            put_in_if_allowed(sample_voids(usable_, prepared_.fans, prepared_.spacing, prepared_.slack,
                                           prepared_.mouths.get(), threads_, progress.part(0, 0.6)),
                              progress.part(0.6, 1));
    }

    /// \returns whether there were any.
    bool put_into_folds(const Progress& progress)
    {
        const int made = put_in_if_allowed(sample_folds(usable_, prepared_.fans, prepared_.spacing, prepared_.slack,
                                                        prepared_.mouths != nullptr, threads_, progress.part(0, 0.6)),
                                           progress.part(0.6, 1));
        result_.fold_points += made;
        return made > 0;
    }

    /// Whether there are any and all would not be more than `max_points`.
    bool may_put_in(const AddedSamples& made) const
    {
        const std::size_t all = input_.points.size() + result_.points.size() + made.samples.points.size();
        return !made.samples.points.empty() && all <= std::size_t(options_.max_points);
    }

    /// Puts in all of these or none, and makes fans and spacing what they become. \returns how many.
    int put_in_if_allowed(const AddedSamples& made, const Progress& progress)
    {
        if (!may_put_in(made))
            return 0;
        const int count = put_in(made, false);
        update_fans(progress);
        update_spacing();
        return count;
    }

    /// Adds made samples to the result and to what is refined. \returns how many.
    int put_in(const AddedSamples& made, bool is_crease)
    {
        const int n = int(usable_.input.size()), before = int(input_.points.size() + result_.points.size());
        for (std::size_t i = 0; i < made.samples.points.size(); ++i)
        {
            std::array<int, 3> parents;
            bool is_frozen = true;
            for (std::size_t m = 0; m < 3; ++m)
            {
                const auto parent = std::size_t(made.parents[i][m]);
                parents[m] = usable_.input[parent];
                is_frozen &= usable_.is_frozen[parent] != 0;
            }
            result_.points.push_back(frame_.from_unit(made.samples.points[i]));
            result_.normals.push_back(made.samples.normals[i]);
            result_.parents.push_back(parents);
            usable_.samples.points.push_back(made.samples.points[i]);
            usable_.samples.normals.push_back(made.samples.normals[i]);
            usable_.input.push_back(before + int(i));
            usable_.beside.push_back(made.parents[i][0]);
            const bool is_shared = i > 0 && made.samples.points[i] == made.samples.points[i - 1];
            usable_.sharing.push_back(is_shared ? usable_.sharing.back() : n + int(i));
            usable_.is_crease.push_back(is_crease);
            usable_.is_frozen.push_back(is_frozen);
        }
        return int(made.samples.points.size());
    }

    void find_fans(const Progress& progress, const InitialFans* before = nullptr,
                   const std::vector<char>& is_changed = {})
    {
        prepared_.fans = find_initial_fans(usable_.samples, *usable_.search, usable_.nearest, usable_.is_crease,
                                           crease_angle(), 1.5, threads_, progress, before, is_changed);
    }

    /// After samples have been added: those that the fans do not know.
    void update_fans(const Progress& progress)
    {
        const std::vector<char> is_changed =
            add_to_nearest(usable_, prepared_.fans.radius.size(), threads_, progress.part(0, 0.5));
        const InitialFans before = std::move(prepared_.fans);
        find_fans(progress.part(0.5, 1), &before, is_changed);
    }

    void update_spacing() { prepared_.spacing = find_spacing(usable_.samples, usable_.nearest, threads_); }

    double crease_angle() const { return options_.crease_angle * radians; }

    const OrientedSamples& input_;
    const PnRefineOptions& options_;
    const PnRefineHints& hints_;
    const UnitFrame& frame_;
    const int threads_;
    Prepared& prepared_;
    UsableSamples& usable_; ///< Of `prepared_`.
    PnRefinement& result_;
};

} // namespace

void prepare_input(const OrientedSamples& input, const PnRefineOptions& options, const PnRefineHints& hints,
                   const UnitFrame& frame, int threads, const Progress& progress, PhaseTimes& times, Prepared& prepared,
                   PnRefinement& result)
{
    Preparation(input, options, hints, frame, threads, prepared, result).run(progress, times);
}

} // namespace recon::pn
