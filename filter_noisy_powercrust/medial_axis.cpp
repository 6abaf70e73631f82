#include "medial_axis.h"

#include "filter_noisy_powercrust/labels/label_cloud.h"
#include "filter_noisy_powercrust/medial/ball_union.h"
#include "filter_noisy_powercrust/medial/sheet_ends.h"

#include <recon/errors.h>
#include <recon/labelling/labelled_balls.h>
#include <recon/parallel.h>
#include <recon/search/neighbours.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <iterator>

namespace recon
{
namespace
{

constexpr double pi = 3.14159265358979323846;

void check(const PowerShapeOptions& options)
{
    if (!(options.ball_threshold >= 0) || !std::isfinite(options.ball_threshold))
        throw InvalidInput("ball_threshold must be 0 (automatic) or a positive length.");
    if (!(options.noise >= 0) || !std::isfinite(options.noise))
        throw InvalidInput("noise must be 0 (estimate) or a positive length.");
    if (!(options.object_angle >= 0 && options.object_angle <= 180))
        throw InvalidInput("object_angle must lie between 0 and 180 degrees.");
    if (!(options.redundancy >= 0 && options.redundancy <= 1))
        throw InvalidInput("redundancy must lie between 0 (keep all) and 1.");
}

/// Cosine of the largest angle between a direction of `first` and one of `second`; 1 if there are none.
double find_lowest_cosine(const std::vector<Vector>& first, const std::vector<Vector>& second)
{
    double lowest = 1;
    for (const Vector& a : first)
        for (const Vector& b : second)
            lowest = std::min(lowest, a.dot(b));
    return lowest;
}

/// The same of samples, seen from the ball's centre.
double cosine_of_largest_angle(const Ball& ball, const std::array<int, 4>& first, const std::array<int, 4>& second,
                               const Points& samples)
{
    const auto list_directions = [&](const std::array<int, 4>& touched)
    {
        std::vector<Vector> directions;
        for (const int i : touched)
            if (i < int(samples.size()))
                directions.push_back((samples[i] - ball.centre).normalized());
        return directions;
    };
    return find_lowest_cosine(list_directions(first), list_directions(second));
}

/// Per ball cosine of its object angle: the largest between two of the samples that it touches. Balls that coincide are
/// one, and touch all that any of them touches.
std::vector<double> list_cosines_of_object_angles(const LabelledBalls& labelled, const Points& samples)
{
    const std::vector<Ball>& balls = labelled.kept.balls;
    const auto& touched = labelled.kept.touched;
    std::vector<double> cosines;
    for (std::size_t b = 0; b < balls.size(); ++b)
        cosines.push_back(cosine_of_largest_angle(balls[b], touched[b], touched[b], samples));
    for (const auto& [hidden, visible] : labelled.twins)
        cosines[visible] = std::min(
            cosines[visible], cosine_of_largest_angle(balls[visible], touched[visible], touched[hidden], samples));
    return cosines;
}

/// A ball of the medial axis touches the surface: seen from a sample its centre lies along the normal, as the largest
/// ball of the side does that this sample touches. Not so of a ball that rests on a ring of samples around a bump of
/// noise. Mean cosine between the two directions below which it is one, unless the samples are of two faces, by the
/// largest angle between their normals [degrees], and the cosine is not as low as the second one.
constexpr double least_tangency = 0.8, two_faces = 50, least_of_two_faces = 0.6;
/// Noise from which there are such balls in a cloud that is not denoised [spacings]: in one that looks free of noise
/// the rule would cost balls of bends.
constexpr double noise_of_strays = 0.06;
/// Radius of the largest of them [local scales]: 2.6; larger ones close holes of the scan.
constexpr double largest_stray = 3;

/// Of a sample's poles on that side, -1 if there is none.
int find_largest_pole(const LabelledBalls& labelled, int sample, Side side)
{
    int largest = -1;
    for (const int pole : labelled.kept.of_sample[sample])
        if (pole >= 0 && labelled.labels[pole] == side &&
            (largest < 0 || labelled.kept.balls[pole].radius > labelled.kept.balls[largest].radius))
            largest = pole;
    return largest;
}

/// Whether a ball rests on noise rather than touches the surface.
bool rests_on_noise(const LabelledBalls& labelled, const Points& samples, int b)
{
    const PolarBalls& kept = labelled.kept;
    if (kept.balls[b].radius > largest_stray * labelled.scale[b])
        return false;
    std::vector<Vector> normals;
    double sum = 0;
    int others = 0;
    for (const int v : kept.touched[b])
    {
        const int pole = v < int(samples.size()) ? find_largest_pole(labelled, v, labelled.labels[b]) : -1;
        if (pole < 0)
            continue;
        normals.push_back((kept.balls[pole].centre - samples[v]).normalized());
        if (pole == b)
            continue;
        sum += normals.back().dot((kept.balls[b].centre - samples[v]).normalized());
        ++others;
    }
    if (others == 0 || sum >= least_tangency * others)
        return false;
    return find_lowest_cosine(normals, normals) > std::cos(two_faces * pi / 180) || sum < least_of_two_faces * others;
}

/// Greedy cover: largest first, drops each ball that sticks out of one that is kept by less than `redundancy` radii.
std::vector<int> find_redundant(const std::vector<Ball>& balls, const std::vector<int>& candidates, double redundancy,
                                const Progress& progress)
{
    constexpr std::size_t report_every = 1024;
    std::vector<int> order = candidates;
    std::sort(order.begin(), order.end(),
              [&](int a, int b)
              { return balls[a].radius != balls[b].radius ? balls[a].radius > balls[b].radius : a < b; });
    // Balls about as large as another are covered from nearby only, of which a plate's would else be asked for all.
    struct Class
    {
        Class(std::size_t begin, double least, Points positions)
            : first(begin), smallest(least), centres(std::move(positions)), search(centres)
        {
        }
        std::size_t first;
        double smallest;
        Points centres;
        NeighbourSearch search;
    };
    constexpr double alike = 1.1;
    std::deque<Class> classes; // stay where they were made: each search refers to its centres
    for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end)
    {
        while (end < order.size() && alike * balls[order[end]].radius >= balls[order[begin]].radius)
            ++end;
        Points centres;
        for (std::size_t k = begin; k < end; ++k)
            centres.push_back(balls[order[k]].centre);
        classes.emplace_back(begin, balls[order[end - 1]].radius, std::move(centres));
    }
    std::vector<char> dropped(order.size(), 0);
    std::vector<int> around, result;
    std::size_t own = 0;
    for (std::size_t k = 0; k < order.size(); ++k)
    {
        if (k % report_every == 0)
            progress.report(double(k) / double(order.size()));
        while (own + 1 < classes.size() && classes[own + 1].first <= k)
            ++own;
        if (dropped[k])
            continue;
        const Ball& large = balls[order[k]];
        for (std::size_t c = own; c < classes.size(); ++c)
        {
            // A covered ball's centre lies within a reach: d + r - R <= redundancy r.
            const double reach = large.radius - (1 - redundancy) * classes[c].smallest;
            classes[c].search.within(large.centre, (1 + 1e-9) * reach, around);
            for (const int i : around)
            {
                const std::size_t j = classes[c].first + std::size_t(i);
                const Ball& small = balls[order[j]];
                if (j > k && !dropped[j] &&
                    (small.centre - large.centre).norm() + small.radius - large.radius <= redundancy * small.radius)
                    dropped[j] = 1;
            }
        }
    }
    for (std::size_t k = 0; k < order.size(); ++k)
        if (dropped[k])
            result.push_back(order[k]);
    return result;
}

/// Visible balls of the side that is asked for: those that the options keep, and those that they drop.
struct ChosenBalls
{
    std::vector<int> wanted, dropped;
};

/// \param is_noisy whether balls may rest on noise.
ChosenBalls choose_balls(const LabelledBalls& labelled, const Points& samples, bool is_noisy,
                         const PowerShapeOptions& options, const Progress& progress)
{
    const std::vector<Ball>& balls = labelled.kept.balls;
    const std::vector<char> is_visible = mark_vertices(labelled.regular, int(balls.size()));
    const double highest_cosine = std::cos(options.object_angle * pi / 180);
    const std::vector<double> cosines = list_cosines_of_object_angles(labelled, samples);
    ChosenBalls chosen;
    for (int b = 0; b < int(balls.size()); ++b)
    {
        const bool inner = labelled.labels[b] == Side::inner;
        const bool of_side = options.side == MedialSide::both || inner == (options.side == MedialSide::inner);
        // Balls around the box have no sample of the shape's other side: they are no part of an outer medial axis.
        if (!is_visible[b] || !of_side || labelled.kept.is_outside[b])
            continue;
        const bool is_wanted = cosines[b] <= highest_cosine && !(is_noisy && rests_on_noise(labelled, samples, b));
        (is_wanted ? chosen.wanted : chosen.dropped).push_back(b);
    }
    if (options.redundancy > 0)
    {
        const std::vector<int> redundant = find_redundant(balls, chosen.wanted, options.redundancy, progress);
        std::vector<char> gone(balls.size(), 0);
        for (const int b : redundant)
            gone[b] = 1;
        chosen.wanted.erase(
            std::remove_if(chosen.wanted.begin(), chosen.wanted.end(), [&](int b) { return gone[b] != 0; }),
            chosen.wanted.end());
        chosen.dropped.insert(chosen.dropped.end(), redundant.begin(), redundant.end());
    }
    return chosen;
}

/// Triangles and loose edges of the regular triangulation all of whose ends are wanted and on one side.
void list_simplices(const Triangulation& regular, const std::vector<Side>& labels, const std::vector<int>& number,
                    PowerShape& shape)
{
    const auto joined = [&](int a, int b)
    { return a >= 0 && b >= 0 && number[a] >= 0 && number[b] >= 0 && labels[a] == labels[b]; };
    const auto edge = [&](int a, int b) -> std::array<int, 2> {
        return {std::min(number[a], number[b]), std::max(number[a], number[b])};
    };
    std::vector<std::array<int, 2>> in_triangles, all;
    for (int c = 0; c < int(regular.cells.size()); ++c)
    {
        const auto& v = regular.cells[c].vertices;
        for (int i = 0; i < 4; ++i)
        {
            for (int j = 0; j < i; ++j)
                if (joined(v[i], v[j]))
                    all.push_back(edge(v[i], v[j]));
            const int a = v[(i + 1) % 4], b = v[(i + 2) % 4], d = v[(i + 3) % 4];
            if (regular.cells[c].neighbours[i] < c || !joined(a, b) || !joined(b, d))
                continue;
            shape.triangles.push_back({number[a], number[b], number[d]});
            in_triangles.insert(in_triangles.end(), {edge(a, b), edge(b, d), edge(d, a)});
        }
    }
    for (auto* edges : {&in_triangles, &all})
    {
        std::sort(edges->begin(), edges->end());
        edges->erase(std::unique(edges->begin(), edges->end()), edges->end());
    }
    std::set_difference(all.begin(), all.end(), in_triangles.begin(), in_triangles.end(),
                        std::back_inserter(shape.edges));
}

/// Continues the sheets of one side to the sharp edges at which they end. \param wanted the balls that are the shape's
/// centres. \param points of the cloud without outliers. \param search of the distinct points.
void reach_edges(const LabelledCloud& found, const std::vector<int>& wanted, bool inner, const Points& points,
                 const NeighbourSearch& search, int threads, const Progress& progress, PowerShape& shape)
{
    const PreparedSamples& cloud = found.cloud;
    std::vector<int> chosen, centre; // of the shape, per ball
    for (std::size_t k = 0; k < wanted.size(); ++k)
        if ((shape.is_inner[k] != 0) == inner)
        {
            chosen.push_back(wanted[k]);
            centre.push_back(int(k));
        }
    const std::vector<AxisBall> balls = list_axis_balls(found.labelled, cloud.samples, chosen);
    const double noise = cloud.denoised ? cloud.noise / cloud.frame.scale() : 0;
    const SheetEnds ends = find_sheet_ends(balls, points, noise, threads, progress);
    const int first = int(shape.centres.size());
    for (const Point& place : ends.places)
    {
        shape.centres.push_back(cloud.frame.from_unit(place));
        shape.is_inner.push_back(inner);
        shape.nearest_sample.push_back(cloud.order[search.nearest(place)]);
    }
    shape.radii.resize(shape.centres.size(), 0);
    for (std::array<int, 3> t : ends.triangles)
    {
        for (int& v : t)
            v = v < int(balls.size()) ? centre[v] : first + v - int(balls.size());
        shape.triangles.push_back(t);
    }
    shape.edge_places += int(ends.places.size());
}

} // namespace

PowerShape compute_power_shape(const Points& points, const PowerShapeOptions& options, const Progress& progress)
{
    const ThreadTeam team;
    check(options);
    PowerShape shape;
    PhaseTimes times;
    SamplePreparationOptions preparation;
    preparation.denoise = options.denoise;
    preparation.noise = options.noise;
    preparation.finds_any_noise = true;
    preparation.threads = options.threads;
    BallLabellingOptions labelling;
    labelling.ball_threshold = options.ball_threshold;
    labelling.noise = options.noise;
    labelling.threads = resolve_threads(options.threads);
    LabelledCloud found = label_cloud(points, preparation, labelling, times, progress.part(0, 0.8, "polar balls"));
    const PreparedSamples& cloud = found.cloud;
    LabelledBalls& labelled = found.labelled;
    const UnitFrame& frame = cloud.frame;
    shape.points_used = int(cloud.distinct.size());
    shape.denoised = cloud.denoised;
    shape.noise = cloud.noise;
    shape.spacing = labelled.spacing * frame.scale();
    shape.violated_votes = labelled.violated_votes;

    times.begin("power shape");
    const Progress ending = progress.part(0.8, 0.9, "power shape");
    ending.report(0);
    const std::vector<Ball>& balls = labelled.kept.balls;
    const bool is_noisy = cloud.denoised || shape.noise > noise_of_strays * shape.spacing;
    const auto [wanted, dropped] = choose_balls(labelled, cloud.samples, is_noisy, options, ending.part(0, 0.2));
    if (wanted.empty())
        throw AlgorithmFailure(
            "No polar ball is left on that side. Lower object_angle, and ball_threshold if it is not 0 (automatic).");
    std::vector<char> is_inner(balls.size(), 0);
    for (const int b : wanted)
        is_inner[b] = labelled.labels[b] == Side::inner;
    const bool has_inner = std::any_of(is_inner.begin(), is_inner.end(), [](char c) { return c != 0; });
    ending.report(0.2);
    if (!dropped.empty())
        labelled.diagram.remove(dropped, labelled.regular, labelling.threads);
    ending.report(0.4);
    if (has_inner)
    {
        const UnionMeasure measure =
            measure_union(labelled.regular, balls, is_inner, labelling.threads, ending.part(0.4, 0.7));
        shape.union_volume = measure.volume * std::pow(frame.scale(), 3);
        shape.union_area = measure.area * std::pow(frame.scale(), 2);
    }
    std::vector<int> number(balls.size(), -1);
    const NeighbourSearch search(cloud.distinct);
    std::vector<int> nearest(wanted.size());
    parallel_for(wanted.size(), labelling.threads, ending.part(0.7, 0.9),
                 [&](std::size_t k) { nearest[k] = search.nearest(balls[wanted[k]].centre); });
    for (std::size_t k = 0; k < wanted.size(); ++k)
    {
        const int b = wanted[k];
        number[b] = int(shape.centres.size());
        shape.centres.push_back(frame.from_unit(balls[b].centre));
        shape.radii.push_back(balls[b].radius * frame.scale());
        shape.is_inner.push_back(is_inner[b]);
        shape.nearest_sample.push_back(cloud.order[nearest[k]]);
        shape.largest_radius = std::max(shape.largest_radius, shape.radii.back());
    }
    list_simplices(labelled.regular, labelled.labels, number, shape);
    if (options.reach_edges)
    {
        times.begin("edges");
        const Points claimed = cloud.denoised ? points_at(cloud.claimed, cloud.distinct) : cloud.distinct;
        for (const bool inner : {true, false})
            if (options.side == MedialSide::both || inner == (options.side == MedialSide::inner))
                reach_edges(found, wanted, inner, claimed, search, labelling.threads,
                            progress.part(inner ? 0.9 : 0.95, inner ? 0.95 : 1, "edges"), shape);
    }
    times.end();
    progress.report(1);
    shape.seconds = times.seconds();
    return shape;
}

} // namespace recon
