#pragma once

#include "filter_pn_refine/samples/usable_samples.h"

#include <recon/search/neighbours.h>

#include <vector>

namespace recon::pn
{

/// Mouths of bores and slits a few spacings wide, and feet of ribs and pins, look like voids of the face that they end
/// in: no rule for triangles tells them apart. The walls do. Those of a bore lie below the face and have a point in its
/// mouth before them; those of a rib stand on the face and have a point in its foot behind them. At an edge both faces
/// lie below each other, at an inner corner both above.
class Mouths
{
public:
    /// \param spacing per sample, the usual distance around it.
    Mouths(const UsableSamples& usable, const std::vector<float>& spacing, int threads, const Progress& progress = {});
    Mouths(const Mouths&) = delete; // the search refers to the samples
    Mouths& operator=(const Mouths&) = delete;

    /// Whether a mouth or foot may be near sample i: triangles across it have such corners. Samples put in since this
    /// was made are what those beside them are.
    bool are_near(std::size_t i, const UsableSamples& usable) const;

    /// Whether a point with this normal would lie in one, so that no surface is there. \param spacing of the samples
    /// around.
    bool hold(const Point& x, const Vector& normal, double spacing) const;

private:
    bool is_near_some(std::size_t i, double spacing) const;

    const OrientedSamples samples_;
    const NeighbourSearch search_;
    std::vector<char> is_near_;
};

} // namespace recon::pn
