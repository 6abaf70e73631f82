#pragma once

#include <recon/labelling/signed_graph.h>
#include <recon/progress.h>
#include <recon/triangulation/polar_balls.h>
#include <recon/triangulation/triangulation.h>

#include <vector>

namespace recon
{

/// Neighbouring balls of a power diagram and how strongly they belong to one side.
struct BallAttraction
{
    std::vector<SignedEdge> edges;          ///< Weight >= 0, in samples.
    std::vector<std::array<int, 2>> merged; ///< Pairs that are certainly on one side.
    std::vector<char> is_on_hull;           ///< Per ball: its power cell is unbounded.
};

struct BallAttractionOptions
{
    double deep_intersection =
        0;                     ///< Cosine above which the paper's rule joins neighbours, (0, 1]; 0 = weigh in samples.
    double merge_above = 0.97; ///< Cosine above which neighbours merge at once; above 1 = never.
    int threads = 1;
};

/// Weighs each pair of neighbouring balls by the samples that would be missing if the surface ran between them: the
/// area in which the power facet cuts the disc of the two spheres' intersection, times the density of samples there.
/// \param density per ball, samples per area.
BallAttraction weigh_attraction(const Triangulation& regular, const std::vector<Ball>& balls,
                                const std::vector<double>& density, const BallAttractionOptions& options,
                                const Progress& progress = {});

/// Area of the intersection of a disc around the origin with a simple polygon, signed by the polygon's direction.
double intersect_disc_with_polygon(double radius, const std::vector<Eigen::Vector2d>& polygon);

} // namespace recon
