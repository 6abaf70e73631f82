#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>

#include <vector>

namespace recon
{

/// Options of find_delaunay_ball_normals().
struct DelaunayBallOptions
{
    double big_ball_ratio =
        0; ///< c: radius from which a ball is big [lambda], >= 0. 0 = the paper's 2.5, and 4 times the noise more.
    int neighbours = 0;     ///< Nearest points whose mean distance is lambda [count], >= 0. 0 = the paper's 5.
    int normal_spread = 20; ///< Points without a big ball take the mean of this many nearest normals [count], >= 1.
    int threads = 0;        ///< Threads to use [count], >= 0. 0 = all cores.
};

/// Normals and poles by the paper's own method; lengths in input units.
struct DelaunayBallNormals
{
    Vectors normals;       ///< Unit, outward; of every point.
    Points poles;          ///< Centres of big balls: the approximate medial axis.
    int with_big_ball = 0; ///< Distinct points whose normal is their own [count].
};

/// Normals from big Delaunay balls (Dey and Sun 2005, section 7; sides by Dey and Goswami 2004: balls of neighbouring
/// cells that intersect deeply lie on one side, beginning outside).
/// \throws InvalidInput for points that do not span a volume or are not finite, or an option out of range.
/// \throws AlgorithmFailure if no ball is big. \throws Cancelled.
DelaunayBallNormals find_delaunay_ball_normals(const Points& points, const DelaunayBallOptions& options = {},
                                               const Progress& progress = {});

} // namespace recon
