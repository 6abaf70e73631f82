#pragma once

namespace recon::pn
{

/// lambda_1, lambda_2, theta_c of the paper and what trials added to them. Lengths in radii of the refined point, or in
/// spacings: the usual distance between points around it at this level (WorkPoint::spacing times what the steps so far
/// have made of it). Both belong to the point, so that the leaf it happens to lie in does not matter.
struct LocalRules
{
    static constexpr float near = 0.57735027f; ///< lambda_1: what is nearer belongs to the new neighbourhood.

    // The discard space: where nothing may be put.
    static constexpr float discard = 0.5f; ///< lambda_2: around other new points, in their radii (eq. 11).
    /// Radii of new points count up to this, in the own radius: a larger one would keep a hole beside the point open.
    static constexpr float discard_most = 0.75f;
    static constexpr float discard_spacings = 0.8f; ///< Nor does it reach farther: radii are large around holes.
    static constexpr float discard_near = 0.25f;    ///< Around new points of the neighbourhood, in their radii.
    static constexpr float near_spacings = 0.4f;    ///< But not farther than this.
    static constexpr float least_distance = 0.1f;   ///< To any point, also one with another normal.
    static constexpr float least_spacings = 0.1f;   ///< The same: in random clusters radii are small.
    /// Nor so that the planes of the nearest points of the level are passed at a larger sine of the angle: such a
    /// triangle joins what lies on two sides of a gap between sheets, or spans detail that the samples do not show.
    static constexpr float largest_slope = 0.5f;

    // Gaps.
    static constexpr float complete_angle = 1.57079633f; ///< theta_c.
    /// [radians] What halves a gap worse does not close it: along a rim it only raises radii.
    static constexpr float least_turn = 0.35f;
    /// [spacings after the step] A gap narrower than theta_c is completed too if the circle through its ends and the
    /// point has a larger radius. Else a hole between few points stays as it is while all around it becomes denser.
    static constexpr float large_gap = 1.1f;
    /// [spacings] What is put into such a gap keeps this distance to all points within the radius that eq. 6 admits; to
    /// the others, as everywhere, least_distance.
    static constexpr float free = 0.4f;
    /// And it comes from a triangle whose normals agree so far: others may lead astray. Where they agree, fans take
    /// more as well (choose_neighbours()).
    static constexpr float firm = 0.95f;
    static constexpr float least_height = 0.1f; ///< Of a candidate's triangle, in its longest edge.
    /// [spacings] Nor has such a triangle a longer edge: it would span a bay of the rim or a hole's side. (At 4 gaps
    /// between random samples stay open.)
    static constexpr float longest_edge = 5;

    // Radii.
    /// No radius written while refining a point exceeds this: radii run away else.
    static constexpr float shrink = 0.9f;
    /// A point with an open gap keeps this: else the radii around a hole shrink below its width, and it is never
    /// closed.
    static constexpr float open_radius = 1;
    static constexpr float largest_open = 4.5f; ///< [spacings] But not if it is larger than this.
    /// [spacings] The radii of a point and of both ends of its gap reach across a circle of more than this radius that
    /// seems empty: else what lies on the other side is never seen, and the hole grows in spacings from step to step.
    static constexpr float seen_gap = 0.65f;
    static constexpr float seen_most = 3;     ///< [spacings] But not farther,
    static constexpr float seen_growth = 1.5; ///< nor farther than this.

    static constexpr float curved_below = 0.95f; ///< Automatic: accurate where a neighbour's normal agrees less.
};

} // namespace recon::pn
