// What stands on a ground, and what a depth camera saw.
#include "filter_amls/reconstruct_amls.h"

#include "tests/ground_scenes.h"

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

TEST(ReconstructAmls, WhatStandsOnAGroundFacesOutwardAndTheGroundIsWhole)
{
    checks::expect_ball_faces_outward_on_a_whole_ground(mesh_of_scene);
}
