#include "refine_leaf.h"

#include "kernels.h"
#include "workspace.h"

#include <recon/parallel.h>

#include <algorithm>
#include <atomic>
#include <thread>

namespace recon::pn
{
namespace
{

/// Collects the old and new points within reach of the leaf; its own old points come first.
void gather(const RefineStep& step, int self, Workspace& w)
{
    const Kernels& kernel = kernels();
    const Leaf& leaf = step.level.leaves[std::size_t(self)];
    w.centre = leaf.box.centre();
    w.scale = 1 / leaf.largest_radius;
    const Vector half = (leaf.box.maximum - leaf.box.minimum) * (0.5 * w.scale);
    const float half_box[3] = {float(half.x()), float(half.y()), float(half.z())};
    w.old_points.count = w.new_points.count = 0;
    w.has_creases = false;
    const double reach2 = 1.0001 * leaf.largest_radius * leaf.largest_radius;
    const auto take = [&](int from)
    {
        const Leaf& other = step.level.leaves[std::size_t(from)];
        const Vector d = (other.box.centre() - w.centre) * w.scale;
        const float offset[3] = {float(d.x()), float(d.y()), float(d.z())};
        // Some are neighbours only because they reach for this one. Children may lie outside the box.
        if (squared_distance(leaf.box, other.box) <= reach2)
            kernel.gather_rows(step.level.rows_of(other), from, other.begin, float(w.scale), offset, half_box,
                               from == self, w.old_points);
        kernel.gather_rows(step.children[std::size_t(from)].rows(), from, 0, float(w.scale), offset, half_box,
                           from == self, w.new_points);
        w.has_creases |= other.has_creases;
    };
    take(self);
    for (int k = step.graph.first[std::size_t(self)]; k < step.graph.first[std::size_t(self) + 1]; ++k)
        take(step.graph.neighbour[std::size_t(k)]);
    w.old_points.pad(w.old_points.count);
    w.new_points.reserve(w.new_points.count + 2 * leaf.size());
    w.new_points.pad(w.new_points.count);
    w.next.assign(std::size_t(w.old_points.count), 0.f);
    w.radius_before.assign(w.new_points.radius, w.new_points.radius + w.new_points.count);
}

/// Touches only the children of this leaf and radii of points and children within its reach, so leaves of one colour
/// may be refined side by side.
void refine_leaf(const RefineStep& step, int self)
{
    thread_local Workspace workspace;
    Workspace& w = workspace;
    gather(step, self, w);
    const int had = w.new_points.count;
    step.children[std::size_t(self)].reserve(step.children[std::size_t(self)].count() +
                                             2 * step.level.leaves[std::size_t(self)].size());
    step.open_gaps[std::size_t(self)] = kernels().refine_points_of_leaf(step, w, self);

    const float unit = float(1 / w.scale);
    for (int j = 0; j < w.new_points.count; ++j)
        if (j >= had || w.new_points.radius[j] != w.radius_before[std::size_t(j)])
            step.children[std::size_t(w.new_points.leaf[j])].radius(w.new_points.index[j]) =
                w.new_points.radius[j] * unit;
    for (int j = 0; j < w.old_points.count; ++j)
        if (const float raised = w.next[std::size_t(j)]; raised > 0)
        {
            float& next = step.next_radius[std::size_t(w.old_points.index[j])];
            next = std::max(next, raised * unit);
        }
}

} // namespace

void refine_leaves(const RefineStep& step, int threads, const Progress& progress)
{
    const std::vector<std::vector<int>>& colours = step.graph.colours;
    std::size_t total = 0;
    for (const std::vector<int>& colour : colours)
        total += colour.size();
    // The same threads work on all colours, since there are many and short ones: whoever finds no leaf left waits for
    // those that others have taken.
    std::vector<std::atomic<std::size_t>> taken(colours.size()), done(colours.size());
    std::atomic<std::size_t> all_done{0};
    std::atomic<bool> stop{false};
    const std::thread::id caller = std::this_thread::get_id();
    const auto work = [&]
    {
        for (std::size_t c = 0; c < colours.size(); ++c)
        {
            const std::vector<int>& colour = colours[c];
            for (std::size_t k; !stop && (k = taken[c]++) < colour.size(); ++done[c])
            {
                refine_leaf(step, colour[k]);
                ++all_done;
                if (std::this_thread::get_id() == caller)
                    progress.report(double(all_done) / double(total));
            }
            while (!stop && done[c] < colour.size())
                std::this_thread::yield();
            if (stop)
                return;
        }
    };
    parallel_for(
        std::size_t(threads), threads, {},
        [&](std::size_t)
        {
            try
            {
                work();
            }
            catch (...)
            {
                stop = true;
                throw;
            }
        },
        1);
}

} // namespace recon::pn
