#pragma once

#include <recon/geometry.h>
#include <recon/labelling/labelled_balls.h>
#include <recon/mesh/crust_mesh.h>
#include <recon/progress.h>
#include <recon/search/block_search.h>

#include <functional>
#include <optional>

namespace recon
{

/// A cloud and its samples in one frame of unit scale. Keeps references.
struct DenoisedCloud
{
    const Points& points;   ///< Distinct, in spatial order; outliers lie anywhere.
    double noise;           ///< Their standard deviation, >= 0.
    const Points& samples;  ///< Projected and thinned.
    const Vectors& normals; ///< Outward, one each.
};

/// Denoised samples with those put on bare flat faces, which come last and replace those around their rims.
struct LabelledNoisyFlats
{
    Points samples;
    Vectors normals;
    LabelledBalls labelled;
    int added = 0;                              ///< [count]
    std::optional<CrustPolygons> polygons = {}; ///< Of the crust, since it was judged by them.
};

/// Whether some of the points lie along lines, as the rims of faces that carry none else do, and no scan. \param points
/// in spatial order; \param search holds them.
bool lie_along_lines(const Points& points, const BlockSearch& search);

/// Labels of denoised samples with the bare flat faces completed that slabs of several widths show. None if there are
/// none, or votes are not clearly for them; not sought where hardly any vote objects to the labels without, or few do
/// and their crust is bare nowhere. \param plain those labels. \param most_noise that was assumed so far, > 0 [units of
/// the frame]. \param polygons gets those of the plain crust, if it had to be asked. \throws Cancelled.
std::optional<LabelledNoisyFlats> label_with_noisy_flats(const DenoisedCloud& cloud, const LabelledBalls& plain,
                                                         double most_noise, const LabelWithin& label,
                                                         std::optional<CrustPolygons>& polygons, PhaseTimes& times,
                                                         int threads);

/// Share of a crust's area that is bare seen from the samples, and where that is more than a lid, share of the points
/// that the crust misses by more than any noise. \param noise standard deviation [units of the points].
double measure_lack(const Points& points, const Points& samples, const TriangleMesh& crust, double noise, int threads);

} // namespace recon
