#pragma once

#include <recon/labelling/signed_graph.h>
#include <recon/triangulation/power_diagram.h>
#include <recon/triangulation/triangulation.h>

#include <limits>
#include <vector>

namespace recon
{

/// Rings through a set of balls, measured along the centres of balls of its side. What is passed to the constructor
/// must stay alive.
class RingSearch
{
public:
    static constexpr double unbounded = std::numeric_limits<double>::infinity();

    RingSearch(const Triangulation& regular, const CellsAtVertices& at, const std::vector<Ball>& balls);
    /// Whether the set's surroundings on its side are in pieces, which are all joined without it within this length.
    /// \param set of one side, not empty.
    bool closes_ring(const std::vector<int>& set, const std::vector<Side>& labels, double longest);

private:
    struct Step
    {
        int ball;
        double length;
    };

    bool counts(int ball, Side side, const std::vector<Side>& labels) const;
    std::vector<int> number_pieces(const std::vector<int>& set, Side side, const std::vector<Side>& labels);
    const std::vector<Step>& steps_from(int ball);
    bool are_joined(const std::vector<int>& seeds, std::size_t count, Side side, const std::vector<Side>& labels);
    bool are_near(const std::vector<int>& seeds, std::vector<int> missing, Side side, const std::vector<Side>& labels,
                  double longest);

    const Triangulation& regular_;
    const CellsAtVertices& at_;
    const std::vector<Ball>& balls_;
    std::vector<std::vector<Step>> steps_; ///< Per ball, empty before it is asked for.
    std::vector<double> distance_;
    std::vector<int> piece_;
    std::vector<char> is_in_;
    std::vector<int> touched_; ///< Balls that have a piece.
};

} // namespace recon
