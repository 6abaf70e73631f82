#pragma once

#include "filter_noisy_powercrust/labels/prepare_samples.h"

#include <recon/geometry.h>
#include <recon/progress.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

namespace recon
{

enum class MedialSide
{
    inner,
    outer,
    both
};

/// Options of compute_power_shape(). Lengths are in input units.
struct PowerShapeOptions
{
    MedialSide side = MedialSide::inner;
    double ball_threshold = 0; ///< Smallest polar ball kept [length], >= 0. 0 = automatic and local.
    double object_angle =
        75; ///< Balls whose samples all lie within this angle seen from the centre are dropped [degrees], 0..180.
    double redundancy =
        0; ///< Balls that a larger one covers up to this share of their radius are dropped, 0..1. 0 = keep all.
    bool reach_edges = true;              ///< Continue sheets to the sharp edges at which they end, see sheet_ends.h.
    Denoise denoise = Denoise::automatic; ///< Whether samples are first projected by AMLS and thinned.
    double noise = 0;                     ///< Standard deviation of the noise [length], >= 0. 0 = estimate.
    int threads = 0; ///< Threads to use [count], >= 0. 0 = all cores. The result does not depend on it.
};

/// Medial axis of the shape that the points bound, as the power shape of its polar balls. Lengths are in input units.
struct PowerShape
{
    Points centres;                  ///< Poles, then places on sharp edges.
    std::vector<double> radii;       ///< Of the balls: distance of the medial axis to the surface, 0 on edges.
    std::vector<char> is_inner;      ///< Per centre.
    std::vector<int> nearest_sample; ///< Per centre: index of the nearest input point.
    std::vector<std::array<int, 3>> triangles; ///< Faces of the regular triangulation between poles of one side.
    std::vector<std::array<int, 2>> edges;     ///< Its edges that belong to no triangle.
    int edge_places = 0;                       ///< How many of the centres are places on sharp edges [count].

    int points_used = 0;
    bool denoised = false;
    double spacing = 0; ///< Median local spacing of the samples [length].
    double noise = 0;   ///< [length]
    double union_volume =
        0;                 ///< Volume of the union of the inner balls [length^3]; 0 if only outer ones were asked for.
    double union_area = 0; ///< Its surface area [length^2].
    double largest_radius = 0;                           ///< [length]
    double violated_votes = 0;                           ///< As in NoisyPowerCrust [0..1].
    std::vector<std::pair<std::string, double>> seconds; ///< Wall-clock seconds per phase.
};

/// Approximates the medial axis by the power shape: the poles of one side and the simplices of the regular
/// triangulation of the polar balls between them (Amenta, Choi and Kolluri 2001). Poles that noise makes go by the
/// radius (Mederos et al. 2005, algorithm 4.1 step 3) and by the object angle: with an angle gamma it is the
/// gamma-medial axis (definition 1). Sheets are continued to the sharp edges at which they end. \throws InvalidInput
/// for points that do not span a volume or are not finite, or an option out of range. \throws AlgorithmFailure if no
/// ball is left. \throws Cancelled.
PowerShape compute_power_shape(const Points& points, const PowerShapeOptions& options = {},
                               const Progress& progress = {});

} // namespace recon
