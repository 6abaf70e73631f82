#pragma once

#include <recon/labelling/signed_graph.h>
#include <recon/progress.h>
#include <recon/triangulation/power_diagram.h>
#include <recon/triangulation/triangulation.h>

#include <functional>
#include <vector>

namespace recon
{

/// Options of remove_short_handles().
struct ShortHandleOptions
{
    double highest_margin = 0.9; ///< Balls at or above this margin are never turned [-1..1].
    /// A handle goes if the evidence for the balls that close it times its ring is below this [samples x local scales].
    double largest_support = 220;
    /// Where normals agree with the balls, only if that times the square of the agreement is below this, too: holes of
    /// two spacings have no more evidence than what noise leaves, but the normals around them point into them.
    double largest_agreement = 25;
    double longest_ring = 40; ///< Whatever its support, no longer one goes [local scales].
    /// Unless the evidence is below this share of the samples that spheres as large as its balls would carry [0..1]:
    /// where an open scan is closed, large balls meet at its rim, and hardly a sample speaks for what hangs there.
    double least_share = 0.0015;
    int rounds = 3;  ///< Handles may hide one another [count].
    int threads = 1; ///< [count], >= 1. The result does not depend on it.
};

/// Removes handles that are short and little supported. Each side grows from its certain balls, the least doubtful
/// first, and leaves out what would close a ring: a set of balls whose turning removes the handle, across its narrowest
/// place, however many balls that takes. Balls of the set that need not turn for that, and for which there is evidence,
/// stay. The set is turned if the evidence for it (kept less violated weight of all edges that leave it), times the
/// length of the ring that it closes, is small; of a set that removes several handles each has its share of that
/// evidence. Measured with normals: real holes 378 and more, what is left of noise
/// mostly below 200; on clean coarse clouds real holes 50. Components are neither joined nor parted.
/// \param scale per ball: local scale of the samples [length]. \param margins per ball, see measure_margins().
/// \param outwardness of a ball, see measure_outwardness().
/// \returns the number of balls turned. \throws Cancelled.
int remove_short_handles(const Triangulation& regular, const SignedGraph& graph, const std::vector<Ball>& balls,
                         const std::vector<double>& scale, const std::vector<double>& margins,
                         const std::function<double(int ball)>& outwardness, const ShortHandleOptions& options,
                         std::vector<Side>& labels, const Progress& progress = {});

/// Euler characteristic of the surface between the sides. \pre every ball on the hull is outer.
int measure_interface_euler(const Triangulation& regular, const std::vector<Side>& labels, int threads = 1);

} // namespace recon
