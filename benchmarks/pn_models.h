#pragma once

#include "filter_pn_refine/refine.h"
#include "models.h"

#include <cstdint>
#include <functional>

/// What the tables of PN refinement share.
namespace benchmarks
{

/// n points spread evenly over the area of a mesh, with the interpolated normals of its vertices.
recon::OrientedSamples sample_mesh(const recon::TriangleMesh& mesh, int n, std::uint64_t seed);
double surface_area(const recon::TriangleMesh& mesh);

/// Largest hole in a cloud that should cover `surface`: from any of its points the distance in its tangent plane to the
/// nearest cloud point on the same side [input units], times `weight` there.
double largest_gap(
    const recon::OrientedSamples& surface, const recon::OrientedSamples& cloud, int threads,
    const std::function<double(const recon::Point&)>& weight = [](const recon::Point&) { return 1.0; });

/// Smallest distance between an appended point and any other [input units].
double closest_pair(const recon::OrientedSamples& input, const recon::Points& appended);

/// Input and appended points together.
recon::OrientedSamples join(const recon::OrientedSamples& input, const recon::PnRefinement& refinement);

/// CGAL's edge_aware_upsample_point_set (Huang et al. 2013) up to `count` points in all, with edge
/// sensitivity 0: with its default of 1 it inserts some 2,000 points a second and then none any more, for ever.
/// \returns the appended points.
struct EdgeAwareUpsampling
{
    recon::OrientedSamples appended;
    double cpu_seconds;
};
EdgeAwareUpsampling upsample_edge_aware(const recon::OrientedSamples& input, int count);

} // namespace benchmarks
