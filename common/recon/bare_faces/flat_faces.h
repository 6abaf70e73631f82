#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>

#include <array>
#include <vector>

namespace recon
{

/// Options of find_flat_faces(). A rim spacing is the distance of a sample to its second nearest.
struct FlatFaceOptions
{
    double tolerance = 0.01; ///< Samples of a plane lie this near to it [rim spacings], > 0.
    int fewest_samples = 12; ///< A plane that counts has as many [count], >= 4.
    int threads = 1;
};

/// Flat part of a surface that carries samples on its rims only, as coarse CAD models have them.
struct FlatFace
{
    Point origin;  ///< Of its plane.
    Vector normal; ///< Of unit length; which side is outside is not known.
    std::vector<std::array<int, 3>>
        triangles;        ///< Indices of samples; counter-clockwise seen from where `normal` points.
    std::vector<int> rim; ///< Its samples that border on what is no face of this plane, ascending.
    Vectors away; ///< By find_noisy_faces(), per rim sample: direction in the plane that leads off the face, of unit
                  ///< length (0 where two rims meet).
};

/// What rims enclose in their planes.
struct FlatFaces
{
    std::vector<FlatFace> bare;   ///< Ground without samples.
    std::vector<FlatFace> narrow; ///< Faces no wider than their rims are spaced: nothing is missing on them.
    /// No faces, but rims: where chamfers, fillets, bores and cylinders end. What they enclose means nothing.
    std::vector<FlatFace> mere_rims;
};

/// Finds planes that hold many samples and bare ground between them, and tells face from void by parity: seen in its
/// plane, a rim has the face on one side only, and infinity is no face. A plane whose rims do not close, or a sheet of
/// samples that crosses the plane, gives no face; nor does ground where the surface is not tangent to the plane (the
/// disc in the mouth of a bowl). Well sampled clouds have none. Rims are also looked for on all levels parallel to a
/// bare face. \param samples distinct, of unit scale (UnitFrame). \throws Cancelled.
FlatFaces find_flat_faces(const Points& samples, const FlatFaceOptions& options = {}, const Progress& progress = {});

} // namespace recon
