#pragma once

#include <algorithm>
#include <vector>

namespace recon
{

/// The widest gap between angles that follow each other around a circle [radians]. \param angles in any order, within
/// one turn, at least one.
inline double widest_turn(std::vector<double> angles)
{
    constexpr double full = 6.283185307179586;
    std::sort(angles.begin(), angles.end());
    double widest = angles.front() + full - angles.back();
    for (std::size_t k = 1; k < angles.size(); ++k)
        widest = std::max(widest, angles[k] - angles[k - 1]);
    return widest;
}

} // namespace recon
