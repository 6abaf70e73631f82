#pragma once

#include "filter_pn_refine/creases/mouths.h"
#include "filter_pn_refine/samples/usable_samples.h"
#include "filter_pn_refine/step/initial_fans.h"
#include "refine.h"

#include <recon/geometry.h>
#include <recon/progress.h>

#include <memory>
#include <vector>

namespace recon::pn
{

constexpr double radians = 0.017453292519943295; ///< Per degree.

/// What the first step begins with.
struct Prepared
{
    UsableSamples usable; ///< With those that were put in.
    InitialFans fans;
    std::vector<float> spacing;     ///< Per usable sample: usual distance to its neighbours.
    std::unique_ptr<Mouths> mouths; ///< Where edges are sharp.
    double slack = 0;               ///< Of a HermiteSurface's gradients.
};

/// Chooses the points that take part, turns contradicting normals, and puts samples onto creases, into holes, voids and
/// folds, as the options say. `result` gets these samples, counts and warnings. \pre `prepared` is empty.
/// \throws InvalidInput if no point has a normal.
void prepare_input(const OrientedSamples& input, const PnRefineOptions& options, const PnRefineHints& hints,
                   const UnitFrame& frame, int threads, const Progress& progress, PhaseTimes& times, Prepared& prepared,
                   PnRefinement& result);

} // namespace recon::pn
