#include "refine_leaf.h"

#include "crowded.h"
#include "kernels.h"
#include "workspace.h"

#include <recon/parallel.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

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
    if (w.has_creases)
        find_faces(step.level, w);
    w.new_points.reserve(w.new_points.count + 2 * leaf.size());
    w.new_points.pad(w.new_points.count);
    w.next.assign(std::size_t(w.old_points.count), 0.f);
    w.radius_before.assign(w.new_points.radius, w.new_points.radius + w.new_points.count);
}

/// Touches only the children of this leaf and radii of points and children within its reach.
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

/// Refines leaves one after the other in space, so that what they share stays in the cache, but each after those of
/// lower colours that it meets: what a leaf finds then depends neither on the threads nor on who came first.
class LeafOrder
{
public:
    explicit LeafOrder(const RefineStep& step) : step_(step), states_(step.level.leaves.size()) {}

    /// Refines the leaf, and before it what must be before it, unless some thread is at it.
    void visit(int leaf)
    {
        const int colour = step_.graph.colour[std::size_t(leaf)];
        std::atomic<State>& state = states_[std::size_t(leaf)];
        State expected = State::waiting;
        if (colour < 0 || !state.compare_exchange_strong(expected, State::taken))
            return;
        try
        {
            for_each_before(leaf, colour, [&](int other) { visit(other); });
            // Who waits waits for lower colours, so that never two wait for each other.
            for_each_before(leaf, colour, [&](int other) { wait_for(other); });
            refine_leaf(step_, leaf);
        }
        catch (...)
        {
            keep(std::current_exception());
            throw;
        }
        state.store(State::done, std::memory_order_release);
    }

private:
    enum class State : char
    {
        waiting,
        taken,
        done
    };

    template <class Visit>
    void for_each_before(int leaf, int colour, Visit&& visit) const
    {
        const LeafGraph& graph = step_.graph;
        for (int k = graph.first[std::size_t(leaf)]; k < graph.first[std::size_t(leaf) + 1]; ++k)
            if (const int other = graph.neighbour[std::size_t(k)], c = graph.colour[std::size_t(other)];
                c >= 0 && c < colour)
                visit(other);
    }
    void wait_for(int leaf)
    {
        while (states_[std::size_t(leaf)].load(std::memory_order_acquire) != State::done)
        {
            if (has_failed_)
                rethrow();
            std::this_thread::yield();
        }
    }
    void keep(const std::exception_ptr& failure)
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (!failure_)
            failure_ = failure;
        has_failed_ = true;
    }
    /// Who waits in vain fails for the same reason: of several failures the caller is told that of the lowest chunk,
    /// which may be the waiter's.
    [[noreturn]] void rethrow()
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        std::rethrow_exception(failure_);
    }

    const RefineStep& step_;
    std::vector<std::atomic<State>> states_;
    std::atomic<bool> has_failed_{false};
    std::mutex mutex_;
    std::exception_ptr failure_; ///< The first.
};

/// First leaves of stretches of [0, n), and n: long ones first, so that threads seldom meet, short ones last, so that
/// all end at the same time.
std::vector<std::size_t> cut_into_stretches(std::size_t n, int threads)
{
    constexpr std::size_t shortest = 16, longest = 1024; // the caller's thread may be cancelled after each
    std::vector<std::size_t> cuts = {0};
    while (cuts.back() < n)
    {
        const std::size_t left = n - cuts.back();
        cuts.push_back(cuts.back() + std::min(left, std::clamp(left / (3 * std::size_t(threads)), shortest, longest)));
    }
    return cuts;
}

} // namespace

void refine_leaves(const RefineStep& step, int threads, const Progress& progress)
{
    LeafOrder order(step);
    const std::vector<std::size_t> cuts = cut_into_stretches(step.level.leaves.size(), threads);
    parallel_for(
        cuts.size() - 1, threads, progress,
        [&](std::size_t stretch)
        {
            for (std::size_t leaf = cuts[stretch]; leaf < cuts[stretch + 1]; ++leaf)
                order.visit(int(leaf));
        },
        1);
}

} // namespace recon::pn
