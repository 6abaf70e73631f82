#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>
#include <recon/triangulation/triangulation.h>

#include <vector>

namespace recon
{

/// Ball of a power diagram.
struct Ball
{
    Point centre;
    double radius;
};

/// Power diagram of balls, as its dual, the regular triangulation with weights radius^2 (RegularTriangulation).
/// Each weight is shrunk by a fixed pseudo-random relative 1e-9: polar balls of noise-free samples all pass through the
/// samples, and so degenerate an input sends nearly every predicate to exact arithmetic.
class PowerDiagram
{
public:
    /// \param is_left_out per ball, if not empty: no member of the diagram, as if hidden.
    /// \pre at least 4 centres are affinely independent; coordinates of the order of 1 (UnitFrame).
    explicit PowerDiagram(const std::vector<Ball>& balls, const std::vector<char>& is_left_out = {});

    /// The dual triangulation, the same for any number of threads; vertices are indices of the balls, hidden balls are
    /// vertices of no cell. \throws Cancelled.
    Triangulation triangulation(int threads = 1, const Progress& progress = {});

    /// Takes these balls out. Balls that were hidden stay hidden. `current`, as triangulation() or the last call gave
    /// it, becomes the dual triangulation of the balls left.
    void remove(const std::vector<int>& balls, Triangulation& current, int threads = 1);

private:
    Points centres_;
    std::vector<double> weights_;
    std::vector<int> present_; ///< Balls that are neither hidden nor removed.
};

} // namespace recon
