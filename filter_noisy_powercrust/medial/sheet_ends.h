#pragma once

#include "filter_noisy_powercrust/edges/edge_place.h"

#include <recon/geometry.h>
#include <recon/labelling/labelled_balls.h>
#include <recon/progress.h>

#include <array>
#include <vector>

namespace recon
{

/// These balls, each with the samples that it and hidden balls in its place touch.
std::vector<AxisBall> list_axis_balls(const LabelledBalls& labelled, const Points& samples,
                                      const std::vector<int>& chosen);

/// What joins a medial axis to the sharp edges at which its sheets end.
struct SheetEnds
{
    Points places; ///< On edges, and corners where these meet.
    /// Strips between balls and edges. A number below that of the balls is a ball's, a higher one a place's.
    std::vector<std::array<int, 3>> triangles;
};

/// The medial axis reaches a sharp edge with radius 0. Balls end before it, the last ones where they touch the samples
/// nearest to it: two spacings and more. Their sheets are continued to the edges that the points around show, if most
/// balls of a neighbourhood do, and several that follow one another. \param balls of one side. \param points in
/// spatial order, without outliers. \param noise their standard deviation [length], >= 0. \throws Cancelled.
SheetEnds find_sheet_ends(const std::vector<AxisBall>& balls, const Points& points, double noise, int threads = 1,
                          const Progress& progress = {});

} // namespace recon
