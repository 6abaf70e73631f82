#pragma once

#include "local_points.h"
#include "refine_leaf.h"

/// What a task knows while it refines a leaf.
namespace recon::pn
{

/// New points near the centre, in its frame. Padded like rings.
struct Arrivals
{
    int count = 0;
    alignas(64) float x[ring_capacity], y[ring_capacity], z[ring_capacity], length[ring_capacity], angle[ring_capacity];
    alignas(64) float nx[ring_capacity], ny[ring_capacity], nz[ring_capacity];
    alignas(64) float reach[ring_capacity];      ///< Nothing may be put nearer than this.
    alignas(64) float near_reach[ring_capacity]; ///< The same once it belongs to N'.
    alignas(64) std::int32_t source[ring_capacity];
    unsigned free[ring_capacity / lane_count]; ///< Per vector: those that may still join N'.
};

/// Centres of the fan's triangles, in the order of the fan.
struct Candidates
{
    alignas(64) float x[lane_count], y[lane_count], z[lane_count], angle[lane_count];
    alignas(64) float nx[lane_count], ny[lane_count], nz[lane_count];
    unsigned usable = 0; ///< Lanes that are candidates.
    unsigned firm = 0;   ///< Lanes whose corners' normals agree.
};

struct Workspace
{
    LocalPoints old_points, new_points;
    std::vector<float> next;          ///< Per old local point: radius to raise it to.
    std::vector<float> radius_before; ///< Per new local point.
    std::vector<std::int32_t> hits;
    std::vector<FaceSector> faces; ///< Per old local point, if there are creases.
    std::vector<char> is_crease;   ///< The same.
    std::vector<int> edge_points;  ///< Old local points whose face is known.
    Ring ring;
    Fan fan;
    Arrivals arrivals;
    Candidates candidates;
    Point centre;
    double scale = 1;
    bool has_creases = false; ///< Some local point lies on one.
};

} // namespace recon::pn
