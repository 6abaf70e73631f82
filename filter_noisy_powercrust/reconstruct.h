#pragma once

#include "filter_noisy_powercrust/labels/prepare_samples.h"

#include <recon/crust/crust.h>
#include <recon/geometry.h>
#include <recon/progress.h>

#include <string>
#include <utility>
#include <vector>

namespace recon
{

/// Options of reconstruct_noisy_power_crust(). Lengths are in input units.
struct NoisyPowerCrustOptions
{
    double ball_threshold = 0;    ///< Smallest polar ball kept [length], >= 0. 0 = automatic and local.
    double noise = 0;             ///< Standard deviation of the noise [length], >= 0. 0 = estimate.
    double deep_intersection = 0; ///< Cosine above which neighbouring balls agree, 0..1. 0 = weighed in samples.
    KeepComponents keep_components = KeepComponents::automatic;
    Denoise denoise = Denoise::automatic; ///< Whether samples are first projected by AMLS and thinned.
    bool smooth = true;   ///< The crust passes through denoised samples and gets its sharp edges back; other vertices
                          ///< of a noisy cloud's crust move onto its AMLS surface. Bare parts are drawn taut.
    bool simplify = true; ///< Collapse short edges, to about one vertex per sample, of a clean cloud at the sample.
    bool open_holes = false; ///< Drop what closes holes and open ends of the scan, told by the spacing, see trim.h.
    double trim_length = 0;  ///< Instead drop triangles farther than this from every point [length], >= 0. 0 = do not.
    int threads = 0;         ///< Threads to use [count], >= 0. 0 = all cores. The result does not depend on it.
};

/// Closed oriented surface and what was chosen on the way. Lengths are in input units.
struct NoisyPowerCrust
{
    TriangleMesh mesh;               ///< Crust; polygon diagonals are faux edges.
    std::vector<int> nearest_sample; ///< Per crust vertex: index of the nearest input point.

    int points_used = 0; ///< Distinct input points [count].
    double spacing = 0;  ///< Median local spacing of the samples [length].
    double noise = 0;    ///< Standard deviation of the noise that was given, told or, see weaving.h, assumed [length].
    double smallest_ball = 0; ///< Radius of the smallest polar ball kept [length].
    bool denoised = false;    ///< Whether the samples were projected and thinned first.
    int samples = 0; ///< Samples the crust was made of: points_used, or fewer after thinning, and `completed` [count].
    int completed = 0;         ///< Samples put on faces that had none [count].
    int edge_vertices = 0;     ///< Vertices moved beside sharp edges, see sharp_edges.h [count].
    int outliers = 0;          ///< Points far from any surface, left out when denoising [count].
    int balls_kept = 0;        ///< [count]
    double violated_votes = 0; ///< Share of the samples' vote weight that the labels contradict [0..1].
    int components = 0;        ///< [count]
    int euler_characteristic = 0;
    int boundary_loops = 0;            ///< 0 unless opened or trimmed [count].
    int genus = 0;                     ///< Summed over the components.
    bool is_convex = false;            ///< Whether all points lie on their convex hull, and that is the surface.
    double cleanness = 0;              ///< Share of samples that look free of noise, as the gate saw it [0..1].
    std::vector<std::string> warnings; ///< In words for the user.
    std::vector<std::pair<std::string, double>> seconds; ///< Wall-clock seconds per phase.
};

/// Reconstructs a closed, outward oriented surface from noisy points without normals (Mederos, Amenta, Velho, de
/// Figueiredo 2005, algorithm 4.1, with a local threshold and a global labelling). Of up to 2,000 points that all lie
/// on their convex hull it can be that, see hull_or(), unless noise, a threshold or open holes are asked for. \throws
/// InvalidInput for points that do not span a volume or are not finite, or an option out of range. \throws
/// AlgorithmFailure if no inner ball is left, or the crust encloses no volume. \throws Cancelled.
NoisyPowerCrust reconstruct_noisy_power_crust(const Points& points, const NoisyPowerCrustOptions& options = {},
                                              const Progress& progress = {});

} // namespace recon
