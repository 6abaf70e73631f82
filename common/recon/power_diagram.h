#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>
#include <recon/triangulation.h>

#include <memory>
#include <vector>

namespace recon
{

/// Ball of a power diagram.
struct Ball
{
    Point centre;
    double radius;
};

/// Power diagram of balls, as its dual, the regular triangulation with weights radius^2 (CGAL, exact predicates).
/// Each weight is shrunk by a fixed pseudo-random relative 1e-9: polar balls of noise-free samples all pass through the
/// samples, and so degenerate an input sends nearly every predicate to exact arithmetic.
class PowerDiagram
{
public:
    /// \pre at least 4 centres are affinely independent; coordinates of the order of 1 (UnitFrame). \throws Cancelled.
    explicit PowerDiagram(const std::vector<Ball>& balls, const Progress& progress = {});
    ~PowerDiagram();
    PowerDiagram(PowerDiagram&&) noexcept;

    /// The dual triangulation; vertices are indices of the balls, hidden balls are vertices of no cell.
    Triangulation triangulation(int threads = 1);

    /// Takes these balls out. Balls that were hidden stay hidden. `current`, as triangulation() or the last call gave it, becomes
    /// the dual triangulation of the balls left.
    void remove(const std::vector<int>& balls, Triangulation& current, int threads = 1);

private:
    struct Regular;
    std::unique_ptr<Regular> regular_;
};

} // namespace recon
