#pragma once

#include <recon/geometry.h>
#include <recon/labelled_balls.h>
#include <recon/progress.h>

namespace recon
{

/// What a crust tells of the samples that it was made of.
struct CrustNormals
{
    TriangleMesh crust;
    Vectors normals; ///< Outward, of unit length; zero where the crust has none.
    int missed = 0;  ///< Samples over half a spacing from every vertex, as where walls were filled [count].
};

/// Gives a vertex at which a closed mesh is folded, so that its normal is opposite to those around, their mean.
/// \param normals of its vertices, of unit length or zero.
void smooth_folds(const TriangleMesh& mesh, Vectors& normals);

/// Outward normals of samples: those of the vertices of the crust through them, the faces' weighted by the sine of
/// the corner over the lengths of its sides (Max 1999), so that lids over holes, whose sides are long, have little say
/// at the rim. \param labelled balls of the samples. \throws AlgorithmFailure if nothing is inside. \throws
/// Cancelled.
CrustNormals list_crust_normals(const Points& samples, const LabelledBalls& labelled, int threads,
                                const Progress& progress = {});

} // namespace recon
