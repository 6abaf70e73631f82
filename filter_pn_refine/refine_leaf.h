#pragma once

#include "level.h"

namespace recon::pn
{

/// How the neighbourhood of a point is found; see PnRefineOptions.
enum class Precision
{
    automatic,
    fast,  ///< Euclidean distances and angles, fuzzy planes in space (section 7).
    fuzzy, ///< Fuzzy planes in space, but curved angles.
    accurate
};

/// What the refinement of one level reads and writes.
struct RefineStep
{
    const Level& level;
    const LeafGraph& graph;
    Precision precision = Precision::automatic;
    float least_crease_agreement = 0;    ///< Cosine of the crease angle: of normals near creases.
    float boundary_angle = 0;            ///< [radians]
    std::vector<LeafChildren>& children; ///< Per leaf.
    std::vector<float>& next_radius;     ///< Per point of the level: raised.
    std::vector<int>& open_gaps;         ///< Per leaf: points whose neighbourhood stayed open.
};

/// Completes the neighbourhoods of the leaf's points (section 5). Touches only the children of this leaf and radii of
/// points and children within its reach, so leaves of one colour may be refined side by side.
void refine_leaf(const RefineStep& step, int leaf);

/// lambda_1, lambda_2, theta_c of the paper and what trials added to them, in radii of the refined point unless said
/// otherwise.
struct LocalRules
{
    static constexpr float near = 0.57735027f;    ///< lambda_1: what is nearer belongs to the new neighbourhood.
    static constexpr float discard = 0.5f;        ///< lambda_2: around other new points, in their radii (eq. 11).
    static constexpr float discard_most = 0.75f;  ///< Radii of new points count up to this, in the own radius: a larger
                                                  ///< one would keep a hole beside the refined point open.
    static constexpr float discard_near = 0.25f;  ///< Around new points of the neighbourhood, in their radii.
    static constexpr float least_distance = 0.1f; ///< To any point, also one with another normal.
    static constexpr float least_usual =
        0.06f; ///< The same in the leaf's median radius: random clusters have small radii.
    static constexpr float complete_angle = 1.57079633f; ///< theta_c.
    static constexpr float least_turn =
        0.35f; ///< [radians] What halves a gap worse does not close it: along a rim it only raises radii.
    static constexpr float shrink =
        0.9f; ///< No radius written while refining a point exceeds this: radii run away else.
    static constexpr float open_radius = 1;      ///< A point with an open gap keeps this: else the radii around a hole
                                                 ///< shrink below its width, and it is never closed.
    static constexpr float largest_open = 2.5f;  ///< But not above this in the leaf's median radius.
    static constexpr float least_height = 0.1f;  ///< Of a candidate's triangle, in its longest edge.
    static constexpr float curved_below = 0.95f; ///< Automatic: accurate where a neighbour's normal agrees less.
};

} // namespace recon::pn
