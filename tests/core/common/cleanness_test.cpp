#include <recon/ball_scale.h>
#include <recon/cleanness.h>
#include <recon/delaunay.h>
#include <recon/spatial_order.h>

#include "tests/shapes.h"

#include <gtest/gtest.h>

using namespace recon;

namespace
{

/// `thickness` in spacings.
Points sample_plate(double thickness, int side)
{
    const Points points = shapes::thin_plate(side, thickness, 5);
    Points ordered;
    for (const int i : order_spatially(points).order)
        ordered.push_back(points[i]);
    return ordered;
}

} // namespace

TEST(Cleanness, AThinPlateIsCleanAndANoisyOneIsNot)
{
    for (const double thickness : {1.5, 2.0, 3.0})
    {
        const Points plate = sample_plate(thickness, 30);
        EXPECT_TRUE(measure_cleanness(plate, 1).is_clean()) << thickness;
        for (const double noise : {0.05, 0.2, 0.5})
            EXPECT_FALSE(measure_cleanness(shapes::with_noisy_copies(plate, noise, 4, 2), 1).is_clean())
                << thickness << ' ' << noise;
    }
}

TEST(Cleanness, IsTheSameForAnyNumberOfThreads)
{
    const Points plate = sample_plate(1.5, 20);
    const Cleanness one = measure_cleanness(plate, 1), many = measure_cleanness(plate, 3);
    EXPECT_EQ(one.long_cells, many.long_cells);
    EXPECT_EQ(one.flat_neighbours, many.flat_neighbours);
}

TEST(Cleanness, NeighboursUpTo17DegreesBelowThePlaneAreFlat)
{
    const Points neighbours = {{1, 0, 0}, {1, 0, -0.25}, {1, 0, -0.4}, {0, 0, -1}};
    EXPECT_EQ(share_of_flat({0, 0, 2}, neighbours.data(), 4), 0.5);
    EXPECT_EQ(share_of_flat({0, 0, 2}, neighbours.data(), 2), 1);
}

TEST(ChooseScale, IsFineAtAThinPlateAndCoarseInNoise)
{
    const Points plate = sample_plate(1.5, 30);
    for (const bool noisy : {false, true})
    {
        Points samples = UnitFrame(plate).to_unit(noisy ? shapes::with_noisy_copies(plate, 0.3, 4, 2) : plate);
        const Points free_samples = samples;
        append_box_corners(samples);
        const Triangulation delaunay = triangulate_delaunay(samples);
        const BlockSearch search(free_samples);
        const SampleSpacing spacing = measure_spacing(free_samples, search, 1);
        const BallScale scale = choose_scale(spacing, free_samples, search, delaunay, find_poles(delaunay, samples));
        int fine = 0;
        for (std::size_t i = 0; i < free_samples.size(); ++i)
            fine += scale.scale[i] == spacing.fine[std::size_t(spacing.nearest[i])];
        const double share = double(fine) / double(free_samples.size());
        EXPECT_EQ(share > 0.95, !noisy);
        EXPECT_EQ(share < 0.05, noisy);
    }
}
