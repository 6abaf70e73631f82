#pragma once

#include <recon/geometry.h>
#include <recon/search/nearest_samples.h>

#include <vector>

namespace recon
{

/// For vertices that lie near samples: the sample that has its seat there, -1 if none has. A sample's seat is the
/// nearest of the vertices whose nearest sample it is.
std::vector<int> seat_samples(const NearestSamples& of_vertices, std::size_t sample_count);

/// Makes a crust pass through samples that are free of noise: vertices move to the samples that have their seats there,
/// samples without a seat become new vertices, and edges are flipped so that the surface bends least (flip_edges.h).
/// The crust stays a closed oriented manifold of the same topology; what would turn a triangle over is left out.
///
/// \param seats per vertex of `mesh`, as by seat_samples().
void interpolate_samples(TriangleMesh& mesh, const std::vector<int>& seats, const Points& samples, int threads = 1);

} // namespace recon
