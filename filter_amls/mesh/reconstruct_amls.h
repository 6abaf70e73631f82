#pragma once

#include "filter_amls/surface/surface.h"

#include <recon/crust/crust.h>
#include <recon/geometry.h>
#include <recon/progress.h>

#include <string>
#include <utility>
#include <vector>

namespace recon
{

/// Options of reconstruct_amls(). Lengths are in input units.
struct AmlsReconstructionOptions
{
    double rho_e = AmlsOptions().rho_e; ///< See AmlsOptions, these three.
    double noise = AmlsOptions().noise;
    int threads = AmlsOptions().threads;
    KeepComponents keep_components = KeepComponents::automatic;
    bool simplify = true;    ///< Collapse short edges, to about one vertex per sample.
    bool open_holes = false; ///< Drop what closes holes and open ends of the scan, told by the spacing, see trim.h.
};

/// Closed oriented mesh of an AMLS surface. Lengths are in input units.
struct AmlsReconstruction
{
    TriangleMesh mesh;
    std::vector<int> nearest_sample; ///< Per vertex: index of the nearest input point.
    AmlsSurfaceReport surface;
    int samples = 0;             ///< Points that the mesh was made of: projected and thinned, or clean [count].
    int completed = 0;           ///< Of these, put on faces that had none [count].
    int outliers = 0;            ///< Points that the surface does not claim [count].
    int vertices_on_surface = 0; ///< Vertices projected onto I = 0; the others close holes, or are clean points or on
                                 ///< bare flat faces [count].
    bool is_convex = false;      ///< Whether all points lie on their convex hull, and that is the surface.
    int components = 0;          ///< [count]
    int euler_characteristic = 0;
    int boundary_loops = 0;            ///< 0 unless opened [count].
    int genus = 0;                     ///< Summed over the components.
    double violated_votes = 0;         ///< Share of the samples' votes that the mesh contradicts [0..1].
    std::vector<std::string> warnings; ///< In words for the user.
    std::vector<std::pair<std::string, double>> seconds; ///< Wall-clock seconds per phase.
};

/// Reconstructs a surface from noisy points without normals (Dey and Sun 2005, section 7): normals, widths, projection,
/// and in place of Cocone a power crust of the projected, thinned points, told inside from outside by an exact cut with
/// their normals. Its vertices are then projected onto I = 0; the topology stays. It is closed where the data closes,
/// and over holes, drawn taut there, unless these are opened. A cloud without noise (cleanness.h) makes the crust as it
/// is, which then passes through its points, unless it is so open that neither they nor the surface's normals tell
/// inside from outside. Of up to 2,000 points that all lie on their convex hull it can be that, see hull_or(), unless a
/// width, noise or open holes are asked for. \throws InvalidInput, AlgorithmFailure, Cancelled.
AmlsReconstruction reconstruct_amls(const Points& points, const AmlsReconstructionOptions& options = {},
                                    const Progress& progress = {});

} // namespace recon
