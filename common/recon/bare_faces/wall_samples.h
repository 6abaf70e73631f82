#pragma once

#include <recon/geometry.h>
#include <recon/search/keep_apart.h>
#include <recon/search/neighbours.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace recon
{

/// Walls up to twice as many rows of samples high have them evenly.
inline constexpr double even_rows = 20;

/// Calls row(above, gap) for rows of samples up to halfway over a rim: `spacing` apart next to it, and only far from
/// both rims farther, as on faces, or rims divided ever finer would have samples by the square. \param above over the
/// rim. \param gap to the row below.
template <class Row>
void list_rows(double height, double spacing, Row&& row)
{
    constexpr double growth = 0.15;
    double gap = spacing; // 0 where squares of distances are too small for a double
    for (double above = gap; gap > 0 && above < 0.5 * height; above += gap)
    {
        row(above, gap);
        gap = spacing + growth * std::max(above - even_rows * spacing, 0.0);
    }
}

/// Gathers samples on walls between rims.
class WallSamples
{
public:
    /// \param present near these no sample stays; outlives this object, as does its search.
    WallSamples(const NeighbourSearch& search, const Points& present) : search_(search), present_(present) {}

    /// From one rim to another, `spacing` apart: where samples are farther apart, walls beside others get handles.
    /// Only far from both rims they are.
    void raise(const Point& foot, const Point& end, double spacing)
    {
        const double height = (end - foot).norm(), pieces = std::ceil(height / spacing);
        if (pieces <= 2 * even_rows)
        {
            for (int k = 1; k < int(pieces); ++k)
                add(foot + (end - foot) * (k / pieces), spacing);
            return;
        }
        list_rows(height, spacing,
                  [&](double above, double gap)
                  {
                      add(foot + (end - foot) * (above / height), gap);
                      add(end + (foot - end) * (above / height), gap);
                  });
    }

    /// Walls may meet, and rise from both of their rims.
    Points thin() const
    {
        const auto has_room = [&](int i)
        { return (present_[search_.nearest(positions_[i])] - positions_[i]).norm() >= radii_[i]; };
        return points_at(keep_apart(positions_, radii_, has_room), positions_);
    }

private:
    void add(const Point& p, double spacing)
    {
        positions_.push_back(p);
        radii_.push_back(0.5 * spacing);
    }

    const NeighbourSearch& search_;
    const Points& present_;
    Points positions_;
    std::vector<double> radii_;
};

} // namespace recon
