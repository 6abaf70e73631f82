#pragma once

#include <recon/geometry.h>
#include <recon/keep_apart.h>
#include <recon/neighbours.h>

#include <cmath>
#include <utility>
#include <vector>

namespace recon
{

/// Gathers samples on walls between rims.
class WallSamples
{
public:
    /// \param present near these no sample is put; outlives this object, as does its search.
    WallSamples(const NeighbourSearch& search, const Points& present) : search_(search), present_(present) {}

    /// From one rim to another, `spacing` apart: farther in between, walls beside others get handles.
    void raise(const Point& foot, const Point& end, double spacing)
    {
        const int pieces = int(std::ceil((end - foot).norm() / spacing));
        for (int k = 1; k < pieces; ++k)
        {
            const Point p = foot + (end - foot) * (double(k) / pieces);
            if ((present_[search_.nearest(p)] - p).norm() < 0.5 * spacing)
                continue;
            positions_.push_back(p);
            radii_.push_back(0.5 * spacing);
        }
    }

    /// Walls may meet, and rise from both of their rims.
    Points thin() const { return points_at(keep_apart(positions_, radii_), positions_); }

private:
    const NeighbourSearch& search_;
    const Points& present_;
    Points positions_;
    std::vector<double> radii_;
};

} // namespace recon
