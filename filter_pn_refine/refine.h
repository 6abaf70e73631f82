#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

namespace recon
{

/// How the one-ring of a point is chosen among the points within its radius.
enum class PnNeighbourhood
{
    automatic, ///< Accurate where the normals around a point differ, fuzzy elsewhere.
    fuzzy,     ///< Fuzzy BSP planes in space (section 4.1): symmetric, fast.
    accurate   ///< The same after the geodesic projection (section 4.2): better where samples are few.
};

/// Options of refine_points(). Lengths are in input units.
struct PnRefineOptions
{
    int steps = 3; ///< Refinement steps, each about doubles the points [count], 0 to 30. 0: only what is put onto
                   ///< creases and into holes.
    double target_radius = 0; ///< Points with a radius at most this are not refined further [length], >= 0; 0 = off.
    PnNeighbourhood neighbourhood = PnNeighbourhood::automatic; ///< Does nothing where `fast` is on.
    bool fast = false;         ///< The shortcuts of section 7, and nothing but PN triangles; folds and voids stay.
    double initial_radius = 0; ///< Radius of each point at the start [length], >= 0; 0 = automatic or given per point.
                               ///< Counts up to 4 times what the point would get automatically.
    double hole_radius = 0;    ///< Holes from some three spacings up to this radius are filled, and bays of outer rims
                               ///< [length], >= 0; 0 = off. Somewhat wider ones may be, too.
    double boundary_angle = 150;     ///< A gap this wide between neighbours makes a rim [degrees], 120 to 180.
    double crease_angle = 45;        ///< Normals that differ by more make a crease [degrees], 0 to 180.
    bool detect_creases = true;      ///< Puts crease samples where two faces end sharply at an angle above
                                     ///< crease_angle; smooth shapes get none. Off: creases are only where two points
                                     ///< share one position.
    bool preserve_boundaries = true; ///< Refines the rim along its own curve.
    bool preserve_creases = true;    ///< Refines creases along their own curve, with both normals.
    bool repair_normals = true;      ///< Turns normals that most neighbours contradict.
    int max_points = 50000000;       ///< What would make more points in all, a step or what comes before the first for
                                     ///< creases, holes, voids or folds, is not done [count], >= 1.
    int threads = 0;                 ///< 0 = all cores. The result does not depend on it.
};

/// What refine_points() may know about the input besides points and normals. Empty: nothing.
struct PnRefineHints
{
    /// Per point, > distance to its farthest natural neighbour; others (<= 0) are found. Made for drawing, radii may
    /// be anything: each counts as at least 1 / 1.5 and at most 4 times what would be found.
    std::vector<double> radii;
    std::vector<char> is_refined;  ///< Per point: 0 = takes part as a neighbour only, and keeps its normal. Nothing is
                                   ///< made from such points alone.
    std::vector<char> is_isolated; ///< Per point: 1 = takes no part; others are told by how far their neighbours are.
};

/// Of one step.
struct PnStepStatistics
{
    int points = 0;                                 ///< In all after it.
    double smallest_radius = 0, largest_radius = 0; ///< [length]
    double median_radius = 0;                       ///< Of some 16,384 of them [length].
    int open_gaps = 0;                              ///< Points whose new neighbourhood stayed open: rims, holes.
};

/// Result of refine_points(). Input points keep their places: only what is new is listed.
struct PnRefinement
{
    Points points;   ///< Appended points.
    Vectors normals; ///< Of unit length, one each.
    std::vector<double> radii;
    /// Per appended point the points it was made from, as indices into input points followed by appended points; always
    /// lower than its own. Its attributes are the mean of the three (points on segments name one of them twice).
    std::vector<std::array<int, 3>> parents;
    std::vector<double> input_radii; ///< Of the input points after the last step; 0 for those that took no part.
    std::vector<int> turned_normals; ///< Input points whose normal was turned before refinement, ascending.
    std::vector<PnStepStatistics> steps;
    PnStepStatistics at_end; ///< Of the last step; of the start, without open gaps, if there was none.
    int boundary_segments = 0, crease_segments = 0; ///< At the start.
    /// Points put onto detected creases before the first step, two at each position (at corners three); they come
    /// first.
    int crease_points = 0;
    int hole_points = 0; ///< Points put into holes before the first step; they come next.
    int void_points = 0; ///< Points put into voids between samples, before the first step; they come after those. None
                         ///< without steps, or if initial_radius or target_radius are given.
    int fold_points = 0; ///< Points put into folds that the samples show too sparsely; they come after those. None
                         ///< without steps.
    int left_out = 0;    ///< Input points that took no part: duplicates, without normal, isolated.
    std::vector<std::pair<std::string, double>> seconds; ///< Per phase.
    std::vector<std::string> warnings;
};

/// Makes an oriented point cloud denser and smooth without moving its points: in every step each point's neighbourhood
/// is completed by centres of PN triangles (Guennebaud, Barthe, Paulin, "Interpolatory Refinement for Real-Time
/// Processing of Point-Based Geometry", Eurographics 2005). Where triangles bend, those of the first step are moved
/// onto the smooth surface through the samples around. Points that cannot take part are left out with a warning.
/// Normals of any length > 0. \pre samples.points and samples.normals have the same size. \throws InvalidInput for no
/// points, a point that is not finite, an option out of range, no usable normal. \throws Cancelled: there is no result.
PnRefinement refine_points(const OrientedSamples& samples, const PnRefineOptions& options = {},
                           const PnRefineHints& hints = {}, const Progress& progress = {});

/// Values of the appended points from those of the input (colour, quality): each the mean of its parents'.
/// \returns one per appended point.
template <class Value>
std::vector<Value> interpolate(const PnRefinement& refinement, const std::vector<Value>& input)
{
    std::vector<Value> made;
    made.reserve(refinement.parents.size());
    const int n = int(input.size());
    const auto at = [&](int i) { return i < n ? input[std::size_t(i)] : made[std::size_t(i - n)]; };
    for (const auto& parents : refinement.parents)
        made.push_back((at(parents[0]) + at(parents[1]) + at(parents[2])) / 3);
    return made;
}

} // namespace recon
