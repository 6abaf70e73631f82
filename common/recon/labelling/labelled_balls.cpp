#include <recon/labelling/labelled_balls.h>

#include <recon/labelling/ball_attraction.h>
#include <recon/labelling/crust_repair.h>
#include <recon/labelling/minimum_cut.h>
#include <recon/labelling/opposite_votes.h>
#include <recon/labelling/short_handles.h>
#include <recon/labelling/signed_labelling.h>
#include <recon/labelling/single_moves.h>
#include <recon/labelling/tube_slices.h>
#include <recon/parallel.h>
#include <recon/search/block_search.h>
#include <recon/search/spatial_order.h>
#include <recon/triangulation/delaunay.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

namespace recon
{
namespace
{

/// Weight, in samples, of what leaves no doubt.
constexpr double certain = 1e3;

/// Parts of the inside with fewer balls, in shares of the largest part, are noise, unless they are bodies.
constexpr double island_share = 0.02;

/// Up to this share of violated votes shared balls gave the labels that all balls give. Where more are, walls are thin
/// or handles small, and every ball counts; but where the outside floods the surface of shared balls, it floods that of
/// all, too (174 clouds). Projected samples violate some by what is left of the noise.
constexpr double undisputed_votes = 0.001, undisputed_votes_with_normals = 0.003;

/// Up to this share of violated votes the balls of clean samples that the spacing lets stay are not doubted: clouds of
/// which a twelfth is noisy violate 0.0036 and more, 0.001 to 0.007 by the local scale; where thin ends look noisy the
/// local scale, which cuts them off, violates more.
constexpr double hardly_disputed_votes = 0.003;

/// So many times BallLabellingOptions::most_violated is far above it: all balls violate 0.8 to 1.1 times what shared
/// ones do, and where the local scale violates clearly less than these, they stay below 0.053.
constexpr double far_above = 1.6;

/// Weight of votes and normals against attraction. With normals 1.5: 1 leaves walls of undersampled flats open and real
/// holes to the repair, 2 adds handles to folds (man, anchor_dense). Where the labels then still contradict most of the
/// cloud, attraction is overrated: across a flat with samples on its rim only, the density of the rim asks for samples
/// that nobody took.
constexpr double free_vote = 1, oriented_vote = 1.5, flooded_vote = 5;

/// Mean over the samples that a ball touches, corners of the box left out.
double average_over(const std::array<int, 4>& touched, const std::vector<double>& per_sample)
{
    double sum = 0;
    int count = 0;
    for (const int v : touched)
        if (v < int(per_sample.size()))
        {
            sum += per_sample[v];
            ++count;
        }
    return count > 0 ? sum / count : 0;
}

std::vector<double> average_over_touched(const PolarBalls& balls, const std::vector<double>& per_sample)
{
    std::vector<double> result;
    result.reserve(balls.balls.size());
    for (const auto& touched : balls.touched)
        result.push_back(average_over(touched, per_sample));
    return result;
}

/// Each sample ties the ball on its outer side to the outside and the one on its inner side to the inside, as strongly
/// as the pole lies along the normal, `strength` at most.
std::vector<TerminalTie> tie_to_normals(const PolarBalls& kept, const Points& samples, const Vectors& normals,
                                        double strength)
{
    std::vector<TerminalTie> ties;
    for (std::size_t v = 0; v < normals.size(); ++v)
        for (const int ball :
             {kept.of_sample[v][0], kept.of_sample[v][1], kept.slant_of_sample[v][0], kept.slant_of_sample[v][1]})
        {
            if (ball < 0)
                continue;
            const double cosine = (kept.balls[ball].centre - samples[v]).normalized().dot(normals[v]);
            if (cosine > 0)
                ties.push_back({ball, Side::outer, strength * cosine});
            else if (cosine < 0)
                ties.push_back({ball, Side::inner, -strength * cosine});
        }
    return ties;
}

/// All indices along the curve of order_spatially(), those of equal points side by side: polar balls come in the order
/// of their samples, and across a hollow their centres are not in order.
std::vector<int> sort_spatially(const Points& points)
{
    const SpatialOrder spatial = order_spatially(points);
    std::vector<int> sorted(points.size());
    std::iota(sorted.begin(), sorted.end(), 0);
    std::stable_sort(sorted.begin(), sorted.end(),
                     [&](int a, int b) { return spatial.representative[a] < spatial.representative[b]; });
    return sorted;
}

/// Distance of centres and difference of radii up to which large balls are alike [local scales], and the radius from
/// which they are large: those inside thin walls differ by less and all matter.
constexpr double like_within = 0.1, like_from_radius = 4;

/// Pairs each of several large balls that are nearly the same with one of them. Those of an exact torus lie on a circle
/// and on its axis, and every one of the circle is the neighbour of every one of the axis: the power diagram of all is
/// quadratic.
std::vector<std::array<int, 2>> pair_like_balls(const PolarBalls& polar, const std::vector<double>& scale, int threads)
{
    std::vector<int> large;
    Points centres;
    for (int b = 0; b < int(polar.balls.size()); ++b)
        if (!polar.is_outside[b] && polar.balls[b].radius >= like_from_radius * scale[b])
        {
            large.push_back(b);
            centres.push_back(polar.balls[b].centre);
        }
    const std::vector<int> sorted = sort_spatially(centres);
    const BlockSearch search(points_at(sorted, centres), threads);
    std::vector<char> has_like(large.size(), 0);
    constexpr std::size_t grain = 4096;
    parallel_chunks(large.size(), threads, grain, {},
                    [&](std::size_t begin, std::size_t end)
                    {
                        for (std::size_t i = begin; i < end; ++i)
                        {
                            const int k = sorted[i];
                            has_like[k] = search.has_within(centres[k], like_within * scale[large[k]], 2);
                        }
                    });
    std::vector<std::array<int, 2>> pairs;
    std::vector<int> around;
    for (int k = 0; k < int(large.size()); ++k)
    {
        if (!has_like[k])
            continue;
        const int b = large[k];
        const double reach = like_within * scale[b];
        search.within(centres[k], reach, around);
        for (int& near : around)
            near = sorted[near];
        std::sort(around.begin(), around.end());
        for (const int near : around)
            if (const int other = large[near];
                near != k && has_like[near] && std::abs(polar.balls[other].radius - polar.balls[b].radius) <= reach)
            {
                pairs.push_back({other, b});
                has_like[near] = 0;
            }
    }
    return pairs;
}

/// Pairs each ball that is no vertex of the diagram with the visible one that hides it, if they are nearly the same: on
/// a sphere thousands of polar balls coincide, one is visible, and the samples' votes must reach it. Those in `pairs`
/// have theirs already.
std::vector<std::array<int, 2>> pair_hidden_balls(const Triangulation& regular, const std::vector<Ball>& balls,
                                                  std::vector<std::array<int, 2>> pairs)
{
    const std::vector<char> is_visible = mark_vertices(regular, int(balls.size()));
    std::vector<char> is_paired(balls.size(), 0);
    for (const auto& pair : pairs)
        is_paired[pair[0]] = 1;
    std::vector<int> visible;
    Points centres;
    for (int b = 0; b < int(balls.size()); ++b)
        if (is_visible[b])
        {
            visible.push_back(b);
            centres.push_back(balls[b].centre);
        }
    if (visible.size() + pairs.size() == balls.size())
        return pairs;
    const BlockSearch search(centres);
    double reach = 0;
    for (int b = 0; b < int(balls.size()); ++b)
        if (!is_visible[b] && !is_paired[b])
        {
            int nearest;
            double squared;
            search.nearest(balls[b].centre, 1, &nearest, &squared, reach);
            const int twin = visible[nearest];
            if ((balls[twin].centre - balls[b].centre).norm() < 1e-3 * balls[b].radius)
                pairs.push_back({b, twin});
        }
    return pairs;
}

/// Without normals a clean coarse cloud's real holes have hardly more evidence than spurious ones: only the least
/// supported go. So it is with normals where there was little noise.
/// \param noise that was taken from the samples [spacings], 0 = not known.
ShortHandleOptions options_for_handles(bool oriented, double noise, int threads)
{
    constexpr double clean_support = 40, noisy_above = 0.1;
    ShortHandleOptions options;
    options.threads = threads;
    const double noisy = !oriented ? 0 : noise > 0 ? std::min(noise / noisy_above, 1.0) : 1;
    options.largest_support = clean_support + noisy * (options.largest_support - clean_support);
    return options;
}

/// Steps 1 and 2: poles of the samples.
struct PolesFound
{
    Triangulation delaunay;
    Poles poles;
    BlockSearch search; ///< Over the samples without the corners of the box.
    SampleSpacing spacing;
};

Points without_corners(const Points& samples)
{
    return {samples.begin(), samples.end() - box_corner_count};
}

/// \param samples with the corners of the box, here and below.
PolesFound find_all_poles(const Points& samples, const Vectors& normals, int threads, PhaseTimes& times,
                          const Progress& progress)
{
    PolesFound result;
    times.begin("Delaunay triangulation");
    const Triangulation& delaunay = result.delaunay =
        triangulate_delaunay(samples, progress.part(0, 0.9, "Delaunay triangulation"), threads);
    const Points free_samples = without_corners(samples);
    result.search = BlockSearch(free_samples, threads);
    result.spacing = measure_spacing(free_samples, result.search, threads);

    times.begin("polar balls");
    result.poles = normals.empty() ? find_poles(delaunay, samples, threads)
                                   : find_poles_along_normals(delaunay, samples, normals, threads);
    find_slant_poles(delaunay, samples, result.poles, threads);
    progress.report(1);
    return result;
}

/// Polar balls that were kept, what the samples say about them, and how fine the samples are there.
struct KeptBalls
{
    PolarBalls polar;
    std::vector<double> scale, density; ///< Per ball: means over the samples that it touches.
    double median_spacing = 0;
    std::vector<SignedEdge> votes;
};

/// Step 3. \param poles those found, or shared ones.
KeptBalls keep_balls(const Points& samples, const PolesFound& found, const BallScale& scale, const Poles& poles,
                     const BallLabellingOptions& options)
{
    KeptBalls result;
    result.polar =
        keep_polar_balls(found.delaunay, samples, poles,
                         [&](double radius, const std::array<int, 4>& touched) {
                             return radius >= (options.ball_threshold > 0 ? options.ball_threshold
                                                                          : average_over(touched, scale.threshold));
                         });
    result.scale = average_over_touched(result.polar, scale.scale);
    result.density = average_over_touched(result.polar, scale.density);
    result.median_spacing = scale.median_spacing;
    result.votes = list_opposite_votes(samples, result.polar, found.search, options.threads);
    return result;
}

/// Attractions between neighbouring balls, pairs that are certain, and the roots.
SignedGraph link_balls(const Triangulation& regular, const KeptBalls& kept,
                       const std::vector<std::array<int, 2>>& twins, bool oriented, const BallLabellingOptions& options,
                       const Progress& progress)
{
    BallAttractionOptions attraction_options;
    attraction_options.deep_intersection = options.deep_intersection;
    attraction_options.threads = options.threads;
    if (oriented)
        attraction_options.merge_above = 2; // normals settle what the shortcut would decide at once
    BallAttraction attraction = weigh_attraction(regular, kept.polar.balls, kept.density, attraction_options, progress);
    SignedGraph graph;
    graph.nodes = int(kept.polar.balls.size());
    graph.edges = std::move(attraction.edges);
    graph.merged = std::move(attraction.merged);
    for (const auto& pair : twins)
    {
        graph.merged.push_back(pair);
        graph.edges.push_back({pair[0], pair[1], certain});
    }
    graph.is_root = kept.polar.is_outside;
    for (int i = 0; i < graph.nodes; ++i)
        graph.is_root[i] |= attraction.is_on_hull[i];
    return graph;
}

/// Labels by attraction, votes and, where given, normals. The votes join the edges of `graph`.
/// \returns the share of the votes that the labels contradict.
double label_balls(SignedGraph& graph, const KeptBalls& kept, const Points& samples, const Vectors& normals,
                   const BallLabellingOptions& options, std::vector<Side>& labels, const Progress& progress)
{
    const bool oriented = !normals.empty() && options.opened.empty();
    const std::size_t attractions = graph.edges.size();
    double violated = 1, done = 0;
    for (const double strength : {oriented ? oriented_vote : free_vote, flooded_vote})
    {
        progress.report(done);
        graph.edges.resize(attractions);
        if (oriented)
            labels = label_by_minimum_cut(graph, tie_to_normals(kept.polar, samples, normals, strength));
        for (const SignedEdge& vote : kept.votes)
            graph.edges.push_back({vote.a, vote.b, strength * vote.weight});
        progress.report(done + 0.25);
        if (oriented)
            SingleMoves(graph, options.threads).improve(labels);
        else
            labels = label_by_best(graph, options.threads);
        violated = measure_violated_repulsion(kept.votes, labels).share();
        done = 0.5;
        // What a user asked for is not talked round.
        if (violated <= flooded_above || options.ball_threshold > 0 || options.deep_intersection > 0)
            break;
    }
    return violated;
}

/// Drops doubtful balls, absorbs islands, removes doubtful and short handles.
/// \param noise that was taken from the samples [length], 0 = not known.
void repair(LabelledBalls& balls, SignedGraph& graph, const Points& samples, const Vectors& normals, double noise,
            int threads, const Progress& progress)
{
    progress.report(0);
    // Margins come from votes that know no normals: normals decide the labels, independent evidence decides which balls
    // are doubtful. Which short handles stay both decide.
    std::vector<double> margins = measure_margins(graph, balls.labels);
    std::vector<char> is_small(balls.labels.size()), is_large(balls.labels.size());
    for (int i = 0; i < graph.nodes; ++i)
    {
        is_small[i] = balls.kept.balls[i].radius < small_below * balls.scale[i];
        is_large[i] = balls.kept.balls[i].radius > balls.scale[i];
    }
    trust_slices_of_tubes(balls.kept.balls, balls.labels, is_small, without_corners(samples),
                          ShortHandleOptions{}.highest_margin, margins, threads);
    std::vector<int> doubtful;
    for (int i = 0; i < graph.nodes; ++i)
        if (is_small[i] && margins[i] < doubtful_below && !balls.kept.is_outside[i])
            doubtful.push_back(i);
    progress.report(0.1);
    spare_bridges(balls.regular, balls.labels, margins, island_share, doubtful, threads);
    if (!doubtful.empty())
        balls.diagram.remove(doubtful, balls.regular, threads);
    progress.report(0.3);
    // A cavity or a ball inside it is an island of one visible ball, for which all its samples stand.
    std::vector<int> weight(std::size_t(graph.nodes), 1);
    for (const auto& [hidden, visible] : balls.twins)
        weight[visible] += std::exchange(weight[hidden], 0);
    // The second round sees what the first joined.
    for (int round = 0; round < 2 && absorb_islands(balls.regular, graph.is_root, weight, is_large, island_share,
                                                    balls.labels, threads) > 0;
         ++round)
        continue;
    progress.report(0.4);
    cut_handles(balls.regular, graph.is_root, is_small, margins, balls.labels, threads);
    progress.report(0.5);
    // Removal can bring other balls to the hull; outside is all that is known there.
    for (std::size_t c = std::size_t(balls.regular.finite_cells); c < balls.regular.cells.size(); ++c)
        for (const int v : balls.regular.cells[c].vertices)
            if (v != Triangulation::infinite)
            {
                balls.labels[v] = Side::outer;
                graph.is_root[v] = 1;
            }
    const auto outwardness = [&](int ball) { return measure_outwardness(balls.kept, ball, samples, normals); };
    remove_short_handles(balls.regular, graph, balls.kept.balls, balls.scale, margins, outwardness,
                         options_for_handles(!normals.empty(), noise / balls.spacing, threads), balls.labels,
                         progress.part(0.5, 1));
}

/// Labels before repair, and what they were found from.
struct Labels
{
    LabelledBalls balls;
    SignedGraph graph;
};

/// Steps 4 and 5.
Labels find_labels(KeptBalls kept, const Points& samples, const Vectors& normals, const BallLabellingOptions& options,
                   PhaseTimes& times, const Progress& progress)
{
    times.begin("power diagram");
    std::vector<std::array<int, 2>> twins = pair_like_balls(kept.polar, kept.scale, options.threads);
    std::vector<char> is_left_out(kept.polar.balls.size(), 0);
    for (const auto& pair : twins)
        is_left_out[pair[0]] = 1;
    PowerDiagram diagram(kept.polar.balls, is_left_out);
    Triangulation regular = diagram.triangulation(options.threads, progress.part(0, 0.5, "power diagram"));

    times.begin("labels");
    twins = pair_hidden_balls(regular, kept.polar.balls, std::move(twins));
    SignedGraph graph =
        link_balls(regular, kept, twins, !normals.empty(), options, progress.part(0.5, 0.8, "attraction of balls"));
    for (const int ball : options.opened)
        graph.is_root[ball] = 1;
    std::vector<Side> labels;
    const Progress labelling = progress.part(0.8, 1, "labels");
    const double violated = label_balls(graph, kept, samples, normals, options, labels, labelling);
    labelling.report(1);
    return {{std::move(kept.polar), std::move(diagram), std::move(regular), std::move(labels), std::move(kept.scale),
             kept.median_spacing, violated, std::move(twins)},
            std::move(graph)};
}

/// With shared balls; none if all balls may contradict fewer votes.
std::optional<Labels> find_shared_labels(const Points& samples, const PolesFound& found, const BallScale& scale,
                                         const Vectors& normals, const BallLabellingOptions& options, PhaseTimes& times,
                                         const Progress& progress)
{
    times.begin("polar balls");
    Poles shared = found.poles;
    share_poles(found.delaunay, samples, shared, options.threads);
    Labels result =
        find_labels(keep_balls(samples, found, scale, shared, options), samples, normals, options, times, progress);
    const double violated = result.balls.violated_votes,
                 undisputed = normals.empty() ? undisputed_votes : undisputed_votes_with_normals;
    result.balls.is_shared = true;
    if (options.sharing == BallSharing::always || violated <= undisputed || violated > flooded_above ||
        violated > far_above * options.most_violated)
        return result;
    return {};
}

/// Steps 3 to 5 before repair. Frees `found` where most memory is needed.
Labels find_best_labels(const Points& samples, PolesFound found, const Vectors& normals,
                        const BallLabellingOptions& options, PhaseTimes& times, const Progress& progress)
{
    const bool oriented = !normals.empty();
    const auto choose_local_scale = [&]
    {
        return choose_scale(found.spacing, without_corners(samples), found.search, found.delaunay, found.poles,
                            options.noise, options.threads);
    };
    times.begin("polar balls");
    const BallScale scale =
        !oriented && options.limit == BallLimit::local ? choose_local_scale() : choose_fine_scale(found.spacing);
    if (options.sharing != BallSharing::none && options.limit != BallLimit::fine && options.opened.empty())
        if (std::optional<Labels> shared =
                find_shared_labels(samples, found, scale, normals, options, times, progress.part(0, 0.4, "labels")))
            return std::move(*shared);
    times.begin("polar balls");
    KeptBalls kept = keep_balls(samples, found, scale, found.poles, options);
    const bool may_have_rival = !oriented && options.limit == BallLimit::fewest_votes && options.ball_threshold == 0;
    if (!may_have_rival)
        found = {};
    Labels result = find_labels(std::move(kept), samples, normals, options, times, progress.part(0.4, 0.7, "labels"));
    if (!may_have_rival || result.balls.violated_votes <= hardly_disputed_votes)
        return result;
    times.begin("polar balls");
    KeptBalls fewer = keep_balls(samples, found, choose_local_scale(), found.poles, options);
    found = {};
    if (fewer.polar.balls.size() == result.balls.kept.balls.size())
        return result;
    Labels local = find_labels(std::move(fewer), samples, normals, options, times, progress.part(0.7, 1, "labels"));
    return local.balls.violated_votes < result.balls.violated_votes ? std::move(local) : std::move(result);
}

} // namespace

LabelledBalls label_polar_balls(Points samples, const Vectors& normals, const BallLabellingOptions& options,
                                PhaseTimes& times, const Progress& progress)
{
    append_box_corners(samples);
    PolesFound found = find_all_poles(samples, normals, options.threads, times, progress.part(0, 0.35, "polar balls"));
    Labels result =
        find_best_labels(samples, std::move(found), normals, options, times, progress.part(0.35, 0.85, "labels"));
    if (result.balls.violated_votes > options.most_violated)
        return std::move(result.balls);
    times.begin("repair");
    const Progress repairing = progress.part(0.85, 1, "repair");
    repair(result.balls, result.graph, samples, normals, options.noise_taken, options.threads, repairing);
    repairing.report(1);
    times.end();
    return std::move(result.balls);
}

} // namespace recon
