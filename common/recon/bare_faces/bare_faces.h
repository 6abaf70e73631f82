#pragma once

#include <recon/geometry.h>
#include <recon/labelling/labelled_balls.h>
#include <recon/progress.h>

#include <cstddef>
#include <functional>
#include <optional>

namespace recon
{

/// Samples put on faces that carry none, flat or not: those of a boundary that a minimum cut finds among Delaunay
/// tetrahedra.
struct BareFaces
{
    Points points;
    Vectors normals;         ///< Outward, of unit length, one each.
    double share = 0;        ///< Of the boundary's area that is bare [0..1].
    double contradicted = 0; ///< Share of the samples' sides that the cut puts on the other side [0..1].
    bool are_wanted = true;  ///< Else there are no points.
    std::size_t pieces = 0;  ///< Of bare facets, among which the points were chosen [count].
};

/// Without these, which facets alone tell, none are filled.
struct BareFacesWanted
{
    double least_share = 0, most_contradicted = 1;
};

/// Labels the Delaunay tetrahedra of samples: each ties the tetrahedra behind and before it to a side, and large faces
/// that no sphere without samples touches cost more to part (Labatut, Pons and Keriven 2009, eq. 9). Bare facets of the
/// boundary, three times as long as the spacing, get samples, less densely away from those that are there. \param
/// samples in spatial order, distinct, of unit scale, at least 4 affinely independent. \param normals outward, of unit
/// length. \throws Cancelled.
BareFaces fill_bare_faces(const Points& samples, const Vectors& normals, const BareFacesWanted& wanted, int threads,
                          const Progress& progress = {});

/// What to tell users where bare faces were filled.
inline constexpr char filled_faces_text[] =
    "Much of the surface has no points, as between the rounded edges of a coarse model: faces were put between those "
    "that there are. Hollows of which no points tell are filled: look at the result, and scan or sample the faces.";

/// What may have them.
struct SamplesOfFaces
{
    OrientedSamples samples; ///< See fill_bare_faces().
    bool are_sheet;          ///< Whether they look like an open sheet, whose lid is bare as well.
};

/// Samples with those put on bare faces, which come last.
struct LabelledBareFaces
{
    Points samples;
    Vectors normals;
    LabelledBalls labelled;
    int added = 0; ///< [count]
};

/// Labels of samples with bare faces filled: of parts whose vertices lie densely on fillets, and none on the faces
/// between. None if votes hardly object, too little is bare, or it does not leave clearly less to object to. \param
/// points of the cloud, 200,000 at most [count]. \param violated share of votes that its labels violate. \param
/// list_samples asked only if they may be needed; it may throw AlgorithmFailure, and so may `label`: then there are
/// none. \throws Cancelled.
std::optional<LabelledBareFaces> label_with_bare_faces(std::size_t points, double violated,
                                                       const std::function<SamplesOfFaces()>& list_samples,
                                                       const LabelWithin& label, PhaseTimes& times, int threads,
                                                       const Progress& progress = {});

} // namespace recon
