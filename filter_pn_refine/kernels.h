#pragma once

#include "level.h"
#include "local_points.h"

namespace recon::pn
{

struct RefineStep;
struct Workspace;

/// The inner loops, compiled for several instruction sets.
struct Kernels
{
    const char* instructions;
    void (*gather_rows)(const RowsView& from, int leaf, int first_index, float scale, const float* offset,
                        const float* half_box, bool takes_all, LocalPoints& to);
    int (*refine_points_of_leaf)(const RefineStep& step, Workspace& w, int leaf);
    void (*finish_children)(const WorkPoint* points, const std::array<int, 3>* corners, int count, WorkPoint* out,
                            std::array<int, 3>* parents);
    /// Ring and fan around the centre from the local points in `hits`, which holds two vectors more than `count`.
    void (*make_fan)(const LocalPoints& points, const Centre& c, std::int32_t* hits, int count, bool accurate,
                     Ring& ring, Fan& fan);
    /// Lists the points within the radius of the centre. \returns how many.
    int (*find_near)(const LocalPoints& points, const Centre& c, std::int32_t* found);
};

/// The fastest that this machine runs.
const Kernels& kernels();

/// All that this machine runs.
std::vector<const Kernels*> all_kernels();

} // namespace recon::pn
