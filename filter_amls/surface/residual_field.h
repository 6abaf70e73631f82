#pragma once

#include "projection.h"
#include "surface.h"

#include <recon/geometry.h>
#include <recon/progress.h>
#include <recon/search/block_search.h>

#include <vector>

namespace recon
{

/// How far the samples lie from the surface, at their places on it. Where some samples are much better than others, as
/// one scan of several, those around a place agree on what the surface errs there: its fits, over a wider
/// neighbourhood, have averaged over that.
struct ResidualField
{
    Points places;
    Vectors normals;              ///< Unit length, outward.
    std::vector<float> residuals; ///< Along the normals.
    BlockSearch search;           ///< Of the places.
    double window = 0;            ///< Over which samples tell an error [widths].
    double robust_scale = 0;      ///< Residuals that are off by more than twice this lose weight [sigma].
    std::vector<float> shares;    ///< Of the error that is told, how much is true, per cell [0..1].

    bool empty() const { return places.empty(); }
};

/// Where it is tried whether two halves of the samples agree: an even stride of those that were moved. Corrections move
/// them by less than a sigma, so that all passes share what is near.
struct TrialPlaces
{
    /// \param projected the samples on the surface, all in the unit frame.
    TrialPlaces(const AmlsSurface::Data& data, const AmlsProjection& projected, int threads);

    std::vector<int> moved;            ///< Samples that were moved; each stride-th is a trial's place.
    std::size_t stride = 1, count = 0; ///< Count of trials.
    std::vector<double> sigma;         ///< Per trial [length].
    std::size_t pooled = 0;            ///< Trials that share their verdict [count].
    std::vector<int> near;             ///< So many for each trial: the nearest, itself among them.
    std::vector<int> of_cell;          ///< The nearest trial, per cell.
};

/// Empty where residuals tell nothing: two halves of the samples do not agree on the error.
/// \param projected the samples on the surface, all in the unit frame. \param window [widths].
ResidualField measure_residuals(const AmlsSurface::Data& data, const AmlsProjection& projected,
                                const TrialPlaces& places, double window, int threads);

/// Moves the points that were moved by what the surface errs there. \param cells of the points.
void correct_by_residuals(const AmlsSurface::Data& data, const ResidualField& field, const std::vector<int>& cells,
                          AmlsProjection& projected, int threads, const Progress& progress = {});

/// Again and again, each time after the corrections before and over another window, until residuals tell nothing more.
/// \param projected the samples on the surface; corrected.
std::vector<ResidualField> measure_residuals_in_passes(const AmlsSurface::Data& data, AmlsProjection& projected,
                                                       int threads);

} // namespace recon
