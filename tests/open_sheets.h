#pragma once

#include "checks.h"
#include "shapes.h"

#include <recon/mesh/mismatch.h>

#include <gtest/gtest.h>

#include <cmath>

/// What both reconstructions must make of open sheets when asked to open what they closed.
namespace open_sheets
{

/// Below them is no ball to be inside, or one here and there: they were projected and thinned, though exact, and had
/// flaps where slab and lid met. \param reconstruct from points to a result whose mesh was opened.
template <class Reconstruct>
void expect_exact_points_kept(const Reconstruct& reconstruct)
{
    struct Case
    {
        const char* name;
        recon::OrientedSamples samples;
    };
    for (const Case& one : {Case{"low terrain", shapes::sheet(4000, shapes::wavy_terrain(0.05, 1, 1), 3)},
                            Case{"terrain", shapes::sheet(4000, shapes::wavy_terrain(0.2, 3, 4), 3)},
                            Case{"S", shapes::sheet(4000, shapes::s_sheet, 3)},
                            Case{"roll", shapes::sheet(4000, shapes::rolled_sheet, 3)}})
    {
        const recon::Points& points = one.samples.points;
        const auto found = reconstruct(points);
        EXPECT_EQ(found.components, 1) << one.name;
        EXPECT_EQ(found.genus, 0) << one.name;
        EXPECT_EQ(found.boundary_loops, 1) << one.name;
        EXPECT_NEAR(double(found.mesh.vertices.size()), double(points.size()), 8) << one.name;
        EXPECT_LT(recon::measure_missed_points(points, found.mesh), 1e-3) << one.name;
        EXPECT_GT(checks::share_faced_one_way(found.mesh, one.samples, 1e-9), 0.998) << one.name;
    }
}

template <class Reconstruct>
void expect_noisy_ones_whole(const Reconstruct& reconstruct)
{
    struct Case
    {
        const char* name;
        recon::OrientedSamples samples;
        double area;
    };
    for (const Case& one : {Case{"terrain", shapes::sheet(10000, shapes::wavy_terrain(0.1, 9, 9), 3), 4.6},
                            Case{"S", shapes::sheet(10000, shapes::s_sheet, 3), 6.1},
                            Case{"roll", shapes::sheet(10000, shapes::rolled_sheet, 3), 7.9}})
    {
        const double sigma = 0.2 * std::sqrt(one.area / double(one.samples.points.size()));
        const auto found = reconstruct(shapes::with_noise(one.samples.points, sigma, 4));
        EXPECT_EQ(found.components, 1) << one.name;
        EXPECT_EQ(found.genus, 0) << one.name;
        EXPECT_EQ(found.boundary_loops, 1) << one.name;
        EXPECT_LT(recon::measure_missed_points(one.samples.points, found.mesh), 2e-3) << one.name;
        EXPECT_GT(checks::share_faced_one_way(found.mesh, one.samples, 0.3), 0.995) << one.name;
    }
}

} // namespace open_sheets
