#pragma once

#include "level.h"
#include "local_points.h"

namespace recon::pn
{

struct RefineStep;
struct Workspace;

/// Boxes side by side, each with a radius; what is not filled lies far away.
struct BoxBlock
{
    static constexpr std::size_t width = 8;
    double minimum[3][width], maximum[3][width], radius[width];

    BoxBlock()
    {
        std::fill_n(minimum[0], 3 * width, 1e100);
        std::fill_n(maximum[0], 3 * width, 1e100);
        std::fill_n(radius, width, 0.0);
    }
};

/// The inner loops, compiled for several instruction sets.
struct Kernels
{
    const char* instructions;
    void (*gather_rows)(const RowsView& from, int leaf, int first_index, float scale, const float* offset,
                        const float* half_box, bool takes_all, LocalPoints& to);
    int (*refine_points_of_leaf)(const RefineStep& step, Workspace& w, int leaf);
    void (*finish_children)(const WorkPoint* points, const std::array<int, 3>* corners, int count, WorkPoint* out,
                            std::array<int, 3>* parents);
    /// Bit i: box i of the block meets the box from minimum to maximum, both grown by their radii.
    unsigned (*meeting_boxes)(const BoxBlock& boxes, const double* minimum, const double* maximum, double radius);
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
