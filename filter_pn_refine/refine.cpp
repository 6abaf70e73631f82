#include "refine.h"

#include "filter_pn_refine/step/crease_sides.h"
#include "filter_pn_refine/step/radius_summary.h"
#include "filter_pn_refine/step/refine_leaf.h"
#include "filter_pn_refine/step/sample_surface.h"
#include "filter_pn_refine/step/segments.h"
#include "prepare_input.h"

#include <recon/errors.h>
#include <recon/parallel.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace recon
{
namespace
{

using namespace pn;

void check_options(const OrientedSamples& samples, const PnRefineOptions& options, const PnRefineHints& hints)
{
    const auto require = [](bool holds, const std::string& message)
    {
        if (!holds)
            throw InvalidInput(message);
    };
    require(samples.points.size() == samples.normals.size(), "There must be one normal for each point.");
    require(hints.radii.empty() || hints.radii.size() == samples.points.size(),
            "There must be one radius for each point.");
    require(hints.is_isolated.empty() || hints.is_isolated.size() == samples.points.size(),
            "There must be one mark for each point that says whether it is isolated.");
    require(hints.is_refined.empty() || hints.is_refined.size() == samples.points.size(),
            "There must be one mark for each point that says whether it is refined.");
    require(options.steps >= 0 && options.steps <= 30, "The number of steps must lie between 0 and 30.");
    const auto is_length = [](double x) { return x >= 0 && std::isfinite(x); };
    require(is_length(options.target_radius), "The target radius must be 0 (off) or more.");
    require(is_length(options.initial_radius), "The initial radius must be 0 (automatic) or more.");
    require(is_length(options.hole_radius), "The hole radius must be 0 (off) or more.");
    require(options.boundary_angle >= 120 && options.boundary_angle <= 180,
            "The boundary angle must lie between 120 and 180 degrees.");
    require(options.crease_angle >= 0 && options.crease_angle <= 180,
            "The crease angle must lie between 0 and 180 degrees.");
    require(options.max_points >= 1, "The largest number of points must be 1 or more.");
}

Precision choose_precision(const PnRefineOptions& options)
{
    if (options.fast)
        return Precision::fast;
    switch (options.neighbourhood)
    {
    case PnNeighbourhood::fuzzy: return Precision::fuzzy;
    case PnNeighbourhood::accurate: return Precision::accurate;
    default: return Precision::automatic;
    }
}

constexpr double most_own_radii = 4; ///< A given radius counts up to this, in those that a point would get itself.

/// Radii for the first step: given, chosen for all, or from the fans.
std::vector<double> choose_radii(const UsableSamples& usable, const InitialFans& fans, const PnRefineOptions& options,
                                 const PnRefineHints& hints, double scale, std::vector<std::string>& warnings)
{
    std::vector<double> radii = fans.radius;
    std::size_t too_large = 0;
    for (std::size_t i = 0; i < radii.size(); ++i)
    {
        double given = options.initial_radius;
        const bool is_hint = given == 0;
        if (is_hint && !hints.radii.empty())
            given = usable.input[i] < int(hints.radii.size()) ? hints.radii[std::size_t(usable.input[i])] : 0;
        // Radii made for drawing are no neighbourhoods: a hint counts within reason. And no point may have all others
        // around it, of whatever kind the radius is: that takes the square of the time and makes nothing.
        too_large += given / scale > most_own_radii * radii[i];
        if (given > 0 && std::isfinite(given))
            radii[i] = std::clamp(given / scale, is_hint ? radii[i] / 1.5 : 0, most_own_radii * radii[i]);
    }
    if (options.initial_radius > 0 && 2 * too_large > radii.size())
        warnings.push_back(
            "The initial radius is too large for most points: it counts as four times what reaches their neighbours, "
            "and even that leaves hardly any room for new ones. At 0 it is found for each point.");
    return radii;
}

class Refinement
{
public:
    Refinement(const OrientedSamples& input, const PnRefineOptions& options, const PnRefineHints& hints)
        : options_(options), frame_(input.points), threads_(resolve_threads(options.threads)),
          input_count_(int(input.points.size())), hints_(hints)
    {
    }

    PnRefinement run(const OrientedSamples& input, const Progress& progress)
    {
        PhaseTimes times;
        Prepared& prepared = prepared_.emplace();
        const double prepared_at = options_.hole_radius > 0 ? 0.3 : 0.15;
        prepare_input(input, options_, hints_, frame_, threads_, progress.part(0, 0.9 * prepared_at), times, prepared,
                      result_);
        const std::vector<std::uint32_t> sides = sides_of_faces(prepared.usable);
        const Progress before_steps = progress.part(0.9 * prepared_at, prepared_at, "segments");
        before_steps.report(0.2);
        find_segments(prepared, sides);
        before_steps.report(0.7);
        start(prepared, sides,
              choose_radii(prepared.usable, prepared.fans, options_, hints_, frame_.scale(), result_.warnings));
        prepared.usable.nearest = {};
        mouths_ = std::move(prepared.mouths);
        times.end();

        reserve_result();
        // Steps take time by how many points they make.
        double total = 0, done = 0;
        for (int s = 0; s < options_.steps; ++s)
            total += std::pow(2.3, s);
        for (int s = 0; s < options_.steps; ++s)
        {
            const double share = std::pow(2.3, s);
            const auto at = [&](double steps) { return prepared_at + (1 - prepared_at) * steps / total; };
            const Progress part = progress.part(at(done), at(done + share), "step " + std::to_string(s + 1));
            if (!refine_level(s + 1 == options_.steps, part, times))
                break;
            done += share;
        }
        result_.at_end = result_.steps.empty() ? describe_start() : result_.steps.back();
        if (result_.input_radii.empty()) // no step was the last of those asked for
            collect_radii([&](std::size_t i) { return level_.points[i].radius; });
        result_.seconds = times.seconds();
        return std::move(result_);
    }

private:
    PnStepStatistics describe_start() const
    {
        RadiusSummary radii(level_.points.size());
        radii.add(level_.rows[6].get(), level_.points.size(), frame_.scale(), threads_);
        return {input_count_ + int(result_.points.size()), radii.smallest(), radii.largest(), radii.median(), 0};
    }

    /// Room for what is expected, within reason, so that results need not be moved.
    void reserve_result()
    {
        const double expected = std::min(double(level_.points.size()) * std::pow(2.3, options_.steps),
                                         std::min(4e6, double(options_.max_points)));
        const std::size_t n = result_.points.size() + std::size_t(expected);
        result_.points.reserve(n);
        result_.normals.reserve(n);
        result_.parents.reserve(n);
        result_.radii.reserve(n);
    }

    void find_segments(const Prepared& prepared, const std::vector<std::uint32_t>& sides)
    {
        if (options_.preserve_boundaries)
            segments_ = find_boundary_segments(prepared.usable, prepared.fans, prepared.spacing,
                                               options_.boundary_angle * radians);
        result_.boundary_segments = int(segments_.size());
        if (options_.preserve_creases)
        {
            const std::vector<Segment> creases =
                find_crease_segments(prepared.usable, prepared.fans, sides, options_.crease_angle * radians);
            result_.crease_segments = int(creases.size());
            segments_.insert(segments_.end(), creases.begin(), creases.end());
        }
    }

    void start(const Prepared& prepared, const std::vector<std::uint32_t>& sides, const std::vector<double>& radii)
    {
        const UsableSamples& usable = prepared.usable;
        const double target = options_.target_radius / frame_.scale();
        std::vector<WorkPoint> points(usable.input.size());
        for (std::size_t i = 0; i < points.size(); ++i)
        {
            WorkPoint& p = points[i];
            p.position = usable.samples.points[i];
            p.normal = usable.samples.normals[i];
            p.radius = float(radii[i]);
            p.spacing = prepared.spacing[i];
            p.id = usable.input[i];
            p.flags = usable.is_frozen[i] ? WorkPoint::frozen
                                          : (double(p.radius) > target && p.radius > 0 ? WorkPoint::refined : 0u);
            if (usable.is_crease[i] && options_.preserve_creases)
                p.flags |= WorkPoint::crease | sides[i];
            if (prepared.mouths && prepared.mouths->are_near(i, usable))
                p.flags |= WorkPoint::near_mouth;
        }
        level_ = make_level(std::move(points));
    }

    /// What a step finds out before the next level is made of it.
    struct StepState
    {
        std::vector<LeafChildren> children;
        std::vector<WorkPoint> on_segments;
        std::vector<InsertedThirds> thirds;
        std::vector<float> next_radius;
        std::vector<int> open_gaps;
        std::vector<int> first; ///< As in Growth.
    };

    /// Per point of the level: what it keeps if it is not refined, else 0.
    std::vector<float> radii_of_unrefined() const
    {
        std::vector<float> radii(level_.points.size(), 0.f);
        parallel_for(level_.leaves.size(), threads_, {},
                     [&](std::size_t k)
                     {
                         const Leaf& leaf = level_.leaves[k];
                         if (leaf.refined_count == leaf.size())
                             return;
                         for (auto i = std::size_t(leaf.begin); i < std::size_t(leaf.end); ++i)
                             if (!(level_.points[i].flags & WorkPoint::refined))
                                 radii[i] = level_.points[i].radius;
                     });
        return radii;
    }

    /// \returns false if no step may follow.
    bool refine_level(bool is_last, const Progress& progress, PhaseTimes& times)
    {
        times.begin("leaves");
        const LeafGraph graph = connect_leaves(level_, threads_, progress.part(0, 0.05, progress_name_));
        if (graph.is_empty)
            return false;
        StepState state;
        state.children = children_memory_.lists_for(level_);
        state.next_radius = radii_of_unrefined();
        state.open_gaps.assign(level_.leaves.size(), 0);

        times.begin("refine");
        // On every odd step (section 6), before what lies beside them.
        const bool is_odd = result_.steps.size() % 2 == 0;
        if (is_odd)
            state.thirds = insert_thirds(segments_, level_, spacing_ratio_, input_count_ + int(result_.points.size()),
                                         threads_, state.children, state.on_segments);
        const RefineStep step{level_,
                              graph,
                              choose_precision(options_),
                              spacing_ratio_,
                              shrinking_,
                              float(std::cos(options_.crease_angle * radians)),
                              float(options_.boundary_angle * radians),
                              mouths_.get(),
                              state.children,
                              state.next_radius,
                              state.open_gaps};
        refine_leaves(step, threads_, progress.part(0.05, 0.9, progress_name_));

        times.begin("grow");
        state.first.assign(state.children.size() + 1, 0);
        for (std::size_t i = 0; i < state.children.size(); ++i)
            state.first[i + 1] = state.first[i] + state.children[i].count();
        const int made = state.first.back();
        const int refined = std::accumulate(level_.leaves.begin(), level_.leaves.end(), 0,
                                            [](int n, const Leaf& leaf) { return n + leaf.refined_count; });
        shrinking_ = float(std::sqrt(refined / double(refined + made)));
        spacing_ratio_ *= shrinking_;
        const int before = input_count_ + int(result_.points.size());
        if (double(before) + made > options_.max_points)
        {
            result_.warnings.push_back("Stopped at " + std::to_string(before) +
                                       " points: the next step would make more than the largest number allowed (" +
                                       std::to_string(options_.max_points) + ").");
            return false;
        }
        if (is_odd)
            segments_ = divide_segments(segments_, state.thirds, state.first, before);
        grow(state, is_last, progress.part(0.9, 1, progress_name_));
        times.end();
        return made > 0;
    }

    /// Appends what a step has made to the result and, unless it is the last, makes the next level of it.
    void grow(const StepState& state, bool is_last, const Progress& progress)
    {
        const int made = state.first.back(), before = input_count_ + int(result_.points.size());
        const std::size_t old = result_.points.size();
        // Each half fills memory that nobody has touched yet.
        parallel_invoke(
            threads_,
            [&]
            {
                result_.points.resize(old + std::size_t(made));
                result_.normals.resize(old + std::size_t(made));
                result_.parents.resize(old + std::size_t(made));
            },
            [&] { result_.radii.resize(old + std::size_t(made)); });
        Growth growth{state.children,
                      state.on_segments,
                      state.first,
                      state.next_radius,
                      before,
                      options_.target_radius / frame_.scale(),
                      {}};
        if (!options_.fast && prepared_)
            growth.correct = [&](const std::array<int, 3>& corners, WorkPoint& made)
            {
                const auto normal = [&](std::size_t m) { return &level_.points[std::size_t(corners[m])].normal; };
                move_onto_sample_surface(prepared_->usable, prepared_->slack, {normal(0), normal(1), normal(2)}, made);
            };
        RadiusSummary radii(std::size_t(before + made));
        const Appended appended{result_.points.data() + old, result_.normals.data() + old, result_.parents.data() + old,
                                result_.radii.data() + old};
        if (is_last)
        {
            append_children(level_, growth, frame_, appended, threads_, progress);
            collect_radii([&](std::size_t i) { return state.next_radius[i]; });
            radii.add(state.next_radius.data(), state.next_radius.size(), frame_.scale(), threads_);
            radii.add(appended.radii, std::size_t(made), 1, threads_);
        }
        else
        {
            level_ = grow_level(level_, growth, frame_, appended, threads_, progress);
            radii.add(level_.rows[6].get(), level_.points.size(), frame_.scale(), threads_);
        }
        result_.steps.push_back({before + made, radii.smallest(), radii.largest(), radii.median(),
                                 std::accumulate(state.open_gaps.begin(), state.open_gaps.end(), 0)});
        prepared_.reset(); // what follows lies between points that are dense enough
    }

    /// Radii of the points of the level go into the result.
    template <class Radius>
    void collect_radii(const Radius& radius_of)
    {
        result_.input_radii.assign(std::size_t(input_count_), 0.0);
        result_.radii.resize(result_.points.size());
        parallel_for(
            level_.points.size(), threads_, {},
            [&](std::size_t i)
            {
                const WorkPoint& p = level_.points[i];
                double& radius = p.id < input_count_ ? result_.input_radii[std::size_t(p.id)]
                                                     : result_.radii[std::size_t(p.id - input_count_)];
                radius = double(radius_of(i)) * frame_.scale();
            },
            4096);
    }

    const std::string progress_name_ = "refining";
    const PnRefineOptions& options_;
    const UnitFrame frame_;
    const int threads_;
    const int input_count_;
    const PnRefineHints& hints_;
    std::unique_ptr<Mouths> mouths_;
    std::optional<Prepared> prepared_; ///< Until the first step is done.
    Level level_;
    ChildrenMemory children_memory_;
    std::vector<Segment> segments_;
    float spacing_ratio_ = 1; ///< By which points have come nearer to each other since the start.
    float shrinking_ = 0.7f;  ///< In the last step; the first usually doubles the points.
    PnRefinement result_;
};

} // namespace

PnRefinement refine_points(const OrientedSamples& samples, const PnRefineOptions& options, const PnRefineHints& hints,
                           const Progress& progress)
{
    const ThreadTeam team;
    check_options(samples, options, hints);
    return Refinement(samples, options, hints).run(samples, progress);
}

} // namespace recon
