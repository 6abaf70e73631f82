// What stands on a ground, what a depth camera saw, and scans out of register.
#include "filter_amls/mesh/reconstruct_amls.h"

#include "tests/checks.h"
#include "tests/ground_scenes.h"
#include "tests/scans.h"

#include <gtest/gtest.h>

using namespace recon;

namespace
{

TriangleMesh mesh_of_scene(const Points& points, bool opens_holes)
{
    AmlsReconstructionOptions options;
    options.open_holes = opens_holes;
    return reconstruct_amls(points, options).mesh;
}

} // namespace

TEST(ReconstructAmls, ABallOverOrBesideAFloorFacesOutward)
{
    checks::expect_ball_apart_from_a_floor_faces_outward(mesh_of_scene);
}

TEST(ReconstructAmls, ATableOverAFloorFacesUpAndIsKept)
{
    checks::expect_table_over_a_floor_faces_up(mesh_of_scene);
}

TEST(ReconstructAmls, ADepthImageFacesItsCamera)
{
    checks::expect_depth_image_faces_its_camera(mesh_of_scene);
}

TEST(ReconstructAmls, AFloorInFarRingsIsWhole)
{
    checks::expect_floor_in_far_rings_is_whole(mesh_of_scene);
}

TEST(ReconstructAmls, WhatStandsOnAGroundFacesOutwardAndTheGroundIsWhole)
{
    checks::expect_ball_faces_outward_on_a_whole_ground(mesh_of_scene);
}

// See NoisyPowerCrust.ViewsOutOfRegisterAreOneSurface.
TEST(ReconstructAmls, ViewsOutOfRegisterAreOneSurface)
{
    constexpr double volume = 2 * 3.14159 * 3.14159 * 0.4 * 0.4;
    for (const int seed : {2, 4})
    {
        const AmlsReconstruction found = reconstruct_amls(shapes::torus_out_of_register(seed).points);
        EXPECT_EQ(found.components, 1) << seed;
        EXPECT_EQ(found.genus, 1) << seed;
        EXPECT_LT(found.violated_votes, 0.004) << seed;
        EXPECT_NEAR(checks::examine_mesh(found.mesh).volume, volume, 0.2 * volume) << seed;
        EXPECT_TRUE(checks::says(found.warnings, "out of register")) << seed;
    }
}
