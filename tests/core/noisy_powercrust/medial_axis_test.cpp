#include "filter_noisy_powercrust/medial_axis.h"

#include "tests/medial_shapes.h"
#include "tests/shapes.h"

#include <recon/errors.h>
#include <recon/search/neighbours.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>

using namespace recon;

namespace
{

constexpr double pi = 3.14159265358979323846;

shapes::MedialError measure_error(const shapes::MedialShape& shape, const PowerShape& found)
{
    return shapes::measure_medial_error(shape, found.centres, found.edges, found.triangles);
}

void expect_sound(const PowerShape& shape)
{
    const int n = int(shape.centres.size());
    ASSERT_GT(n, 0);
    EXPECT_EQ(shape.radii.size(), shape.centres.size());
    EXPECT_EQ(shape.nearest_sample.size(), shape.centres.size());
    for (const auto& t : shape.triangles)
        for (int k = 0; k < 3; ++k)
        {
            ASSERT_TRUE(t[k] >= 0 && t[k] < n);
            EXPECT_NE(t[k], t[(k + 1) % 3]);
        }
    for (const auto& e : shape.edges)
        EXPECT_TRUE(e[0] >= 0 && e[0] < e[1] && e[1] < n);
}

} // namespace

TEST(PowerShape, OfATorusIsItsCircle)
{
    const shapes::MedialShape torus = shapes::medial_torus(6000, 1);
    for (const double noise : {0.0, 0.22})
    {
        SCOPED_TRACE(noise);
        const PowerShape shape = compute_power_shape(torus.noisy(noise, true, 2));
        expect_sound(shape);
        EXPECT_EQ(shape.denoised, noise > 0);
        EXPECT_LT(measure_error(torus, shape).hausdorff(), 1.5);
        EXPECT_NEAR(shape.union_volume, 6 * pi * pi, 0.015 * shape.union_volume);
        EXPECT_NEAR(shape.union_area, 12 * pi * pi, 0.015 * shape.union_area);
        EXPECT_NEAR(shape.largest_radius, 1, 0.1);
    }
}

TEST(PowerShape, OfACapsuleIsItsSegment)
{
    const shapes::MedialShape capsule = shapes::medial_capsule(5000, 2);
    for (const double noise : {0.0, 0.25})
    {
        const PowerShape shape = compute_power_shape(capsule.noisy(noise, true, 3));
        expect_sound(shape);
        EXPECT_LT(measure_error(capsule, shape).hausdorff(), 1.5) << noise;
        EXPECT_EQ(shape.denoised, noise > 0);
    }
}

// One point each: a crust needs no help there, but each bump would make a twig.
TEST(PowerShape, DenoisesEvenALittleNoise)
{
    for (const double noise : {0.01, 0.05, 0.16})
        for (const shapes::MedialShape& solid :
             {shapes::medial_torus(6000, 4), shapes::medial_capsule(5000, 4), shapes::medial_box(5000, 4)})
        {
            SCOPED_TRACE(solid.name + ' ' + std::to_string(noise));
            const PowerShape shape = compute_power_shape(solid.noisy(noise, false, 9));
            EXPECT_TRUE(shape.denoised);
            EXPECT_LT(measure_error(solid, shape).strays, 1.5); // 4.7 to 11 raw
            EXPECT_LT(measure_error(solid, shape).unreached, 2);
        }
    const PowerShape fat = compute_power_shape(shapes::with_noise(shapes::torus(4000, 1, 0.4, 1).points, 0.01, 2));
    EXPECT_TRUE(fat.denoised);
    for (const Point& p : fat.centres)
        EXPECT_LT(std::hypot(p.head<2>().norm() - 1, p.z()), 0.15);
}

TEST(PowerShape, OfABoxReachesIntoItsCorners)
{
    const shapes::MedialShape box = shapes::medial_box(20000, 4);
    for (const double noise : {0.0, 0.2})
    {
        SCOPED_TRACE(noise);
        const PowerShape shape = compute_power_shape(box.noisy(noise, true, 5));
        expect_sound(shape);
        EXPECT_LT(measure_error(box, shape).hausdorff(), 1.5);
        EXPECT_NEAR(shape.union_volume, 24, noise > 0 ? 2 : 1.2) << "balls leave the corners out";
    }
}

// Balls end two spacings and more before the edges, at gaps between samples three.
TEST(PowerShape, SheetsReachSharpEdgesAndCorners)
{
    for (const double noise : {0.0, 0.1, 0.2})
        for (const bool with_copies : {false, true})
        {
            SCOPED_TRACE(std::to_string(noise) + ' ' + std::to_string(with_copies));
            const shapes::MedialShape box = shapes::medial_box(5000, 6);
            const Points points = box.noisy(noise, with_copies, 7);
            PowerShapeOptions options;
            const PowerShape shape = compute_power_shape(points, options);
            expect_sound(shape);
            EXPECT_LT(measure_error(box, shape).unreached, 1.5);
            const std::size_t poles = shape.centres.size() - std::size_t(shape.edge_places);
            const NeighbourSearch search(points);
            int corners = 0;
            for (std::size_t i = 0; i < shape.centres.size(); ++i)
            {
                EXPECT_EQ(shape.radii[i] == 0, i >= poles);
                if (i < poles)
                    continue;
                EXPECT_EQ(shape.nearest_sample[i], search.nearest(shape.centres[i]));
                std::array<double, 3> off; // of a place from the three nearest faces
                for (int k = 0; k < 3; ++k)
                    off[k] = std::abs(std::abs(shape.centres[i][k]) - 2 + 0.5 * k) / box.spacing;
                std::sort(off.begin(), off.end());
                EXPECT_LT(off[1], 0.6);
                corners += off[2] < 0.6;
            }
            EXPECT_GE(corners, 8);
            if (with_copies)
                continue;
            options.reach_edges = false;
            const PowerShape alone = compute_power_shape(points, options);
            EXPECT_EQ(alone.edge_places, 0);
            EXPECT_EQ(alone.centres.size(), poles);
            EXPECT_EQ(alone.union_volume, shape.union_volume);
            EXPECT_GT(measure_error(box, alone).unreached, 2);
        }
}

TEST(PowerShape, RoundedEdgesAreNoEnds)
{
    const double rounding = 0.25; // two and a half spacings
    const shapes::MedialShape box = shapes::medial_box(5000, 6);
    shapes::MedialShape rounded = box;
    for (Point& p : rounded.points)
    {
        const Vector most = Vector(2, 1.5, 1) - Vector::Constant(rounding);
        const Point inner = p.cwiseMin(most).cwiseMax(-most);
        p = inner + rounding * (p - inner).normalized();
    }
    for (const double noise : {0.0, 0.1, 0.3})
    {
        EXPECT_GT(compute_power_shape(box.noisy(noise, true, 7)).edge_places, 100) << noise;
        EXPECT_EQ(compute_power_shape(rounded.noisy(noise, true, 7)).edge_places, 0) << noise;
        for (const shapes::MedialShape& round : {shapes::medial_torus(6000, 1), shapes::medial_capsule(5000, 2)})
            EXPECT_EQ(compute_power_shape(round.noisy(noise, true, 7)).edge_places, 0) << round.name << noise;
    }
}

TEST(PowerShape, NoisyTubesHaveNoEnds)
{
    const int n = 6000;
    for (const double minor : {0.1, 0.3}) // 2.3 and 3.9 spacings
        for (const int copies : {0, 4})
        {
            const double noise = 0.5 * std::sqrt(4 * pi * pi * 3 * minor / n);
            const Points exact = shapes::torus(n, 3, minor, 5).points;
            const Points points =
                copies > 0 ? shapes::with_noisy_copies(exact, noise, copies, 6) : shapes::with_noise(exact, noise, 6);
            EXPECT_EQ(compute_power_shape(points).edge_places, 0) << minor << ' ' << copies; // else 123, 167, 743
        }
}

TEST(PowerShape, OfTheOutsideReachesConcaveEdges)
{
    // An L of boxes 2 x 1 x 1.5 and 1 x 2 x 1.5: its concave edge is x = y = 1.
    const Points around = shapes::box(20000, Vector(2, 2, 1.5), 8).points;
    Points points;
    for (const Point& centred : around)
    {
        Point p = centred + Vector(1, 1, 0);
        if (p.x() <= 1 || p.y() <= 1)
            points.push_back(p);
        else if (p.x() == 2)
            points.emplace_back(1, p.y(), p.z()); // faces of the square that is missing move inwards
        else if (p.y() == 2)
            points.emplace_back(p.x(), 1, p.z());
    }
    PowerShapeOptions options;
    options.side = MedialSide::outer;
    const PowerShape outer = compute_power_shape(points, options);
    EXPECT_GT(outer.edge_places, 10);
    for (std::size_t i = outer.centres.size() - std::size_t(outer.edge_places); i < outer.centres.size(); ++i)
    {
        EXPECT_NEAR(outer.centres[i].x(), 1, 0.02);
        EXPECT_NEAR(outer.centres[i].y(), 1, 0.02);
    }
    options.side = MedialSide::both;
    const PowerShape both = compute_power_shape(points, options), inner = compute_power_shape(points);
    EXPECT_EQ(both.edge_places, inner.edge_places + outer.edge_places);
    for (const auto& t : both.triangles)
        EXPECT_TRUE(both.is_inner[t[0]] == both.is_inner[t[1]] && both.is_inner[t[1]] == both.is_inner[t[2]]);
}

TEST(PowerShape, IsTheSameForAnyNumberOfThreads)
{
    const Points points = shapes::medial_box(5000, 6).noisy(0.1, true, 7);
    PowerShapeOptions options;
    options.threads = 1;
    const PowerShape one = compute_power_shape(points, options);
    options.threads = 3;
    const PowerShape three = compute_power_shape(points, options);
    EXPECT_EQ(one.centres, three.centres);
    EXPECT_EQ(one.triangles, three.triangles);
    EXPECT_EQ(one.union_volume, three.union_volume);
    EXPECT_GT(one.edge_places, 0);
}

TEST(PowerShape, NoBallRestsOnNoise)
{
    const shapes::MedialShape box = shapes::medial_box(5000, 4);
    EXPECT_LT(measure_error(box, compute_power_shape(box.noisy(0.3, true, 9))).strays, 1); // else 2.2
}

TEST(PowerShape, OfAnExactSphereIsItsCentre)
{
    const PowerShape shape = compute_power_shape(shapes::sphere(3000, 1, 5).points);
    ASSERT_FALSE(shape.centres.empty());
    for (std::size_t i = 0; i < shape.centres.size(); ++i)
    {
        EXPECT_LT(shape.centres[i].norm(), 1e-6);
        EXPECT_NEAR(shape.radii[i], 1, 1e-6);
    }
    EXPECT_NEAR(shape.union_volume, 4 * pi / 3, 1e-3);
}

// All poles lie at one place: 4.5 times the Delaunay triangulation's time while each of them looked at all others.
TEST(PowerShape, OfAnExactSphereIsNotQuadratic)
{
    const PowerShape shape = compute_power_shape(shapes::sphere(30000, 1, 1).points);
    const auto seconds = [&](const std::string& phase)
    {
        double sum = 0;
        for (const auto& [name, time] : shape.seconds)
            sum += name == phase ? time : 0;
        return sum;
    };
    EXPECT_GT(seconds("Delaunay triangulation"), 0);
    EXPECT_LT(seconds("power diagram"), 1.5 * seconds("Delaunay triangulation"));
}

TEST(PowerShape, AFarOutlierHardlyChangesTheVolume)
{
    Points points = shapes::with_noise(shapes::torus(3000, 1, 0.4, 1).points, 0.01, 2);
    for (const double far : {10.0, 1000.0})
    {
        points.emplace_back(far, far, far);
        EXPECT_NEAR(compute_power_shape(points).union_volume, 2 * pi * pi * 0.16, 0.2) << far;
        points.pop_back();
    }
}

TEST(PowerShape, SidesAndPruningDoWhatTheySay)
{
    const Points points = shapes::torus(3000, 3, 1, 1).points;
    PowerShapeOptions options;
    options.side = MedialSide::both;
    const PowerShape both = compute_power_shape(points, options);
    options.side = MedialSide::outer;
    const PowerShape outer = compute_power_shape(points, options);
    const PowerShape inner = compute_power_shape(points);
    const auto inside = [](const Point& p) { return std::hypot(p.head<2>().norm() - 3, p.z()) < 1; };
    EXPECT_TRUE(std::all_of(inner.centres.begin(), inner.centres.end(), inside));
    EXPECT_TRUE(std::none_of(outer.centres.begin(), outer.centres.end(), inside));
    EXPECT_EQ(both.centres.size(), inner.centres.size() + outer.centres.size());
    EXPECT_EQ(outer.union_volume, 0);

    options.side = MedialSide::inner;
    options.redundancy = 0.2;
    const PowerShape sparse = compute_power_shape(points, options);
    EXPECT_LT(sparse.centres.size(), inner.centres.size() / 2);
    EXPECT_NEAR(sparse.union_volume, inner.union_volume, 0.1 * inner.union_volume);
    options.redundancy = 0;
    options.object_angle = 150;
    EXPECT_LT(compute_power_shape(points, options).centres.size(), inner.centres.size());
}

TEST(PowerShape, RefusesOptionsOutOfRange)
{
    const Points points = shapes::sphere(200, 1, 1).points;
    for (const auto& spoil :
         std::vector<std::function<void(PowerShapeOptions&)>>{
             [](auto& o) { o.object_angle = 181; }, [](auto& o) { o.redundancy = -0.1; }, [](auto& o) { o.noise = -1; },
             [](auto& o) { o.ball_threshold = NAN; }, [](auto& o) { o.threads = -1; }})
    {
        PowerShapeOptions options;
        spoil(options);
        EXPECT_THROW(compute_power_shape(points, options), InvalidInput);
    }
    PowerShapeOptions options;
    options.ball_threshold = 100;
    EXPECT_THROW(compute_power_shape(points, options), AlgorithmFailure);
}
