#pragma once

#include <recon/geometry.h>
#include <recon/labelling/labelled_balls.h>
#include <recon/progress.h>

#include <array>
#include <functional>
#include <vector>

namespace recon
{

/// What a crust tells of the samples that it was made of.
struct CrustNormals
{
    TriangleMesh crust;
    Vectors normals;               ///< Outward, of unit length; zero where the crust has none.
    std::vector<double> distances; ///< From each sample to the nearest vertex [length].
};

/// Normals of the vertices of a closed mesh, of unit length or zero: sums of what the faces at each contribute. One
/// that is opposite to those around, as where the mesh is folded, is their mean, if these agree. \param at_corner what
/// a triangle contributes at one of its corners, 0 to 2.
Vectors sum_corner_normals(const TriangleMesh& mesh,
                           const std::function<Vector(const std::array<int, 3>&, int)>& at_corner);

/// Outward normals of samples: those of the vertices of the crust through them, the faces' weighted by the sine of
/// the corner over the lengths of its sides (Max 1999), so that lids over holes, whose sides are long, have little say
/// at the rim. \param labelled balls of the samples. \throws AlgorithmFailure if nothing is inside. \throws
/// Cancelled.
CrustNormals list_crust_normals(const Points& samples, const LabelledBalls& labelled, int threads,
                                const Progress& progress = {});

} // namespace recon
