#pragma once

#include "filter_pn_refine/creases/mouths.h"
#include "level.h"
#include "local_rules.h"

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
    float spacing_ratio = 1;             ///< Of the usual distance between points now to WorkPoint::spacing.
    float shrinking = 1;                 ///< Of that distance after the step to before it, as expected.
    float least_crease_agreement = 0;    ///< Cosine of the crease angle: of normals near creases.
    float boundary_angle = 0;            ///< [radians]
    const Mouths* mouths = nullptr;      ///< Where nothing is put; null: there are none.
    std::vector<LeafChildren>& children; ///< Per leaf.
    std::vector<float>& next_radius;     ///< Per point of the level: raised.
    std::vector<int>& open_gaps;         ///< Per leaf: points whose neighbourhood stayed open.
};

/// Completes the neighbourhoods of all points to refine (section 5): each leaf after those of lower colours that it
/// meets, the others side by side.
void refine_leaves(const RefineStep& step, int threads, const Progress& progress);

} // namespace recon::pn
