#include "one_thread.h"

#include "filter_pn_refine/sharpen_normals.h"

#include "tests/shapes.h"

#include <recon/search/neighbours.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace
{

using namespace recon;

/// Round at edges, as normals fitted to the points around are.
Vectors means_of_nearest(const OrientedSamples& samples)
{
    constexpr int k = 12;
    const NeighbourSearch search(samples.points);
    Vectors means;
    for (const Point& p : samples.points)
    {
        int near[k];
        double squared[k];
        search.nearest(p, k, near, squared);
        Vector sum = Vector::Zero();
        for (int j : near)
            sum += samples.normals[std::size_t(j)];
        means.push_back(sum.normalized());
    }
    return means;
}

/// Share of the normals that are more than 10 degrees off.
double share_off(const Vectors& normals, const Vectors& exact)
{
    int off = 0;
    for (std::size_t i = 0; i < exact.size(); ++i)
        off += normals[i].dot(exact[i]) < std::cos(0.175);
    return double(off) / double(exact.size());
}

TEST(SharpenNormals, EdgesTurnUpAgain)
{
    const OrientedSamples box = shapes::box(8000, Vector(2, 2, 2), 3);
    const OrientedSamples computed{box.points, means_of_nearest(box)};
    const Vectors sharpened = pn::sharpen_normals(computed, one_thread(0));
    EXPECT_GT(share_off(computed.normals, box.normals), 0.12);
    EXPECT_LT(share_off(sharpened, box.normals), 0.05);
    EXPECT_EQ(refine_points(computed, one_thread(0)).crease_points, 0);
    EXPECT_GT(refine_points({box.points, sharpened}, one_thread(0)).crease_points, 500);
    PnRefineOptions threads;
    threads.threads = 3;
    EXPECT_EQ(pn::sharpen_normals(computed, threads), sharpened);
}

TEST(SharpenNormals, SmoothShapesAndNoiseKeepTheirs)
{
    const OrientedSamples torus = shapes::torus(3000, 1, 0.4, 2);
    const OrientedSamples computed{torus.points, means_of_nearest(torus)};
    EXPECT_EQ(pn::sharpen_normals(computed, one_thread(0)), computed.normals);

    OrientedSamples noisy = shapes::box(8000, Vector(2, 2, 2), 3);
    shapes::Random random(1);
    for (Point& p : noisy.points)
        for (int k = 0; k < 3; ++k)
            p[k] += 0.012 * (shapes::uniform(random) - 0.5); // a fifth of the spacing from end to end
    noisy.normals = means_of_nearest(noisy);
    EXPECT_EQ(pn::sharpen_normals(noisy, one_thread(0)), noisy.normals);
}

TEST(SharpenNormals, DuplicatesFollowAndIsolatedPointsKeepTheirs)
{
    OrientedSamples box = shapes::box(8000, Vector(2, 2, 2), 3);
    box.normals = means_of_nearest(box);
    box.points.push_back(box.points.front()); // a duplicate
    box.normals.push_back(box.normals.front());
    box.points.emplace_back(50, 0, 0);
    box.normals.push_back(Vector::UnitX());
    const Vectors sharpened = pn::sharpen_normals(box, one_thread(0));
    EXPECT_NE(sharpened[0], box.normals[0]);
    EXPECT_EQ(sharpened[8000], sharpened[0]);
    EXPECT_EQ(sharpened.back(), box.normals.back());
    const OrientedSamples without{{Point(0, 0, 0)}, {Vector::Zero()}};
    EXPECT_EQ(pn::sharpen_normals(without, one_thread(0)), without.normals);
}

} // namespace
