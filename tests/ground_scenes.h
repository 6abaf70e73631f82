#pragma once

#include "checks.h"
#include "scans.h"
#include "shapes.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <utility>

/// What every filter that makes a surface of a scene over a ground must get right.
namespace checks
{

using Reconstruct = std::function<recon::TriangleMesh(const recon::Points& points, bool opens_holes)>;

/// Seen from above, so that only its top is there, without legs, and its shadow on the floor.
inline void expect_table_over_a_floor_faces_up(const Reconstruct& reconstruct)
{
    const recon::OrientedSamples scene = shapes::table_over_a_floor(4);
    const recon::TriangleMesh mesh = reconstruct(shapes::with_noise(scene.points, 0.2, 5), true);
    EXPECT_GT(share_faced(mesh, scene, 3), 0.97);
}

/// At the wall its steps are one and two and a half pixels deep. Moved, its place is told by the order of the points.
inline void expect_depth_image_faces_its_camera(const Reconstruct& reconstruct)
{
    for (const recon::Vector& shift : {recon::Vector(0, 0, 0), recon::Vector(3, -2, 1)})
        for (const double step : {0.003, 0.008})
        {
            recon::OrientedSamples frame = shapes::depth_frame(80, step, 4);
            for (recon::Point& p : frame.points)
                p += shift;
            EXPECT_GT(share_faced(reconstruct(frame.points, step < 0.005), frame, 0.1), 0.85) << step << shift.x();
        }
}

/// Without noise a scanner of few beams reads the floor of a room in rings up to 27 times as far apart as readings:
/// a back three readings behind it comes between the rings, and between them looks like a hole.
inline void expect_floor_in_far_rings_is_whole(const Reconstruct& reconstruct)
{
    const recon::OrientedSamples rings = shapes::scan_by_beams(1800, 12, 0, 5, -30, 15);
    EXPECT_GT(share_faced(reconstruct(rings.points, true), rings, 0.1), 0.98);
}

/// Over the floor the small one has few balls, and with other seeds none that stay (3 of 40); beside it the floor has
/// no things before it, and which of its sides is the outside the ball alone tells.
inline void expect_ball_apart_from_a_floor_faces_outward(const Reconstruct& reconstruct)
{
    for (const double x : {20, 60})
        for (const auto& [radius, seed] : {std::pair{9, 4}, std::pair{5, 6}})
        {
            const recon::OrientedSamples scene =
                shapes::ball_apart_from_a_floor({x, 5, 30}, radius, std::uint64_t(seed));
            const recon::TriangleMesh mesh = reconstruct(shapes::with_noise(scene.points, 0.2, 5), true);
            EXPECT_GT(share_faced(mesh, scene, 3), 0.99) << x << " " << radius;
        }
}

/// Whichever axis is up.
inline void expect_ball_faces_outward_on_a_whole_ground(const Reconstruct& reconstruct)
{
    const recon::Points level = shapes::with_noise(shapes::ball_on_a_ground(4), 0.2, 5);
    for (const int up : {2, 1})
    {
        recon::Points points = level;
        if (up == 1)
            for (recon::Point& p : points)
                p = recon::Point(p.x(), p.z(), -p.y());
        for (const bool is_opened : {false, true})
        {
            recon::TriangleMesh mesh = reconstruct(points, is_opened);
            const MeshReport report = examine_mesh(mesh);
            EXPECT_EQ(report.components, 1);
            EXPECT_EQ(report.is_closed_oriented_manifold(), !is_opened) << report.text();
            if (up == 1)
                for (recon::Point& p : mesh.vertices)
                    p = recon::Point(p.x(), -p.z(), p.y());
            const SceneReport scene = examine_ball_on_a_ground(mesh);
            EXPECT_GT(scene.ball, 0.9) << up << is_opened;
            EXPECT_GT(scene.ground, 0.9) << up << is_opened;
        }
    }
}

} // namespace checks
