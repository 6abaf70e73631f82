#include "filter_amls/sides/face_cameras.h"

#include "tests/checks.h"
#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace recon;

TEST(FaceCamera, TurnsWhatFacesAwayAndWhatGrazingRaysDoNotTell)
{
    // A floor and a wall seen from low above the floor's middle; the wall is turned over, and so is a part of the
    // floor.
    shapes::Random random(7);
    OrientedSamples seen;
    for (int i = -40; i <= 40; ++i)
        for (int j = -40; j <= 40; ++j)
        {
            const auto jitter = [&] { return 0.4 * (shapes::uniform(random) - 0.5); };
            seen.points.emplace_back(i + jitter(), j + jitter(), 0);
            seen.points.emplace_back(42, i + jitter(), 42 + j + jitter());
            seen.normals.push_back(Vector(jitter(), jitter(), 1).normalized());
            seen.normals.push_back(Vector(-1, jitter(), jitter()).normalized());
        }
    Vectors normals = seen.normals;
    for (std::size_t k = 0; k < normals.size(); ++k)
        if (k % 2 == 1 || seen.points[k].y() > 5)
            normals[k] = -normals[k];
    const Point camera(0, 0, 2);
    const Viewpoints cameras(camera);
    const auto share_facing_camera = [&](const Vectors& chosen)
    {
        double facing = 0;
        for (std::size_t k = 0; k < chosen.size(); ++k)
            facing += chosen[k].dot(camera - seen.points[k]) > 0;
        return facing / double(chosen.size());
    };
    EXPECT_LT(share_facing_camera(seen.normals), 0.9) << "each ray alone is no judge";
    for (const int threads : {1, 3})
    {
        Vectors turned = normals;
        face_cameras(cameras, seen.points, turned, threads);
        EXPECT_GT(checks::share_facing(turned, seen.normals), 0.99);
    }
}

TEST(FaceCamera, AcceptsNothingAndAPointAtTheCamera)
{
    Vectors none, one = {Vector::UnitX()};
    face_cameras(Viewpoints(Point::Zero()), {}, none, 1);
    face_cameras(Viewpoints(Point::Zero()), {Point::Zero()}, one, 1);
    EXPECT_EQ(one.front(), Vector::UnitX());
}
