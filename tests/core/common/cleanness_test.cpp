#include <recon/labelling/ball_scale.h>
#include <recon/noise/cleanness.h>
#include <recon/scramble.h>
#include <recon/search/spatial_order.h>
#include <recon/triangulation/delaunay.h>

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

using namespace recon;

namespace
{

Points in_order(const Points& points)
{
    return points_at(order_spatially(points).order, points);
}

/// `thickness` in spacings.
Points sample_plate(double thickness, int side)
{
    return in_order(shapes::thin_plate(side, thickness, 5));
}

double torus_spacing(const Points& torus)
{
    return std::sqrt(4 * EIGEN_PI * EIGEN_PI * 0.3 / double(torus.size()));
}

/// Share of the samples from `begin` to before `end` whose scale is the fine one.
double share_of_fine(const Points& points, std::size_t begin, std::size_t end)
{
    Points samples = UnitFrame(points).to_unit(points);
    const Points free_samples = samples;
    append_box_corners(samples);
    const Triangulation delaunay = triangulate_delaunay(samples);
    const BlockSearch search(free_samples);
    const SampleSpacing spacing = measure_spacing(free_samples, search, 1);
    const BallScale scale = choose_scale(spacing, free_samples, search, delaunay, find_poles(delaunay, samples));
    int fine = 0;
    for (std::size_t i = begin; i < end; ++i)
        fine += scale.scale[i] == spacing.fine[std::size_t(spacing.nearest[i])];
    return fine / double(end - begin);
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

TEST(Cleanness, OfSheetsInAStackItIsThatOfOne)
{
    for (const double gap : {1.6, 2.5})
    {
        const Points stack = shapes::stack_of_sheets(16, 30, gap, 3);
        EXPECT_LT(measure_cleanness(in_order(stack), 1).roughness, 0.05) << gap;
        for (const double noise : {0.1, 0.2})
        {
            const Cleanness noisy = measure_cleanness(in_order(shapes::with_noise(stack, noise, 4)), 1);
            EXPECT_TRUE(noisy.is_smooth_but_noisy()) << gap << ' ' << noise;
            EXPECT_NEAR(noisy.roughness, noise, 0.35 * noise) << gap << ' ' << noise;
        }
    }
}

TEST(Cleanness, AWiderFitServesNoiseAsWellAndCurvatureNot)
{
    for (const Points& shape : {shapes::torus(1500, 1, 0.3, 3).points, shapes::box(1500, {3, 2, 1}, 3).points})
    {
        const Cleanness clean = measure_cleanness(in_order(shape), 1);
        EXPECT_LT(clean.whiteness, 0.5);
        EXPECT_FALSE(clean.is_smooth_but_noisy());
    }
    const Points torus = shapes::torus(12'000, 1, 0.3, 3).points;
    const double spacing = std::sqrt(4 * EIGEN_PI * EIGEN_PI * 0.3 / double(torus.size()));
    for (const double noise : {0.1, 0.25})
    {
        const Cleanness noisy = measure_cleanness(in_order(shapes::with_noise(torus, noise * spacing, 4)), 1);
        EXPECT_TRUE(noisy.is_smooth_but_noisy()) << noisy.whiteness;
        EXPECT_NEAR(noisy.roughness, noise, 0.25 * noise);
    }
}

TEST(Cleanness, NoiseInOnePartIsToldFromACloudThatIsCoarseAllOver)
{
    const Points torus = shapes::torus(20'000, 1, 0.3, 3).points;
    for (const double noise : {0.4, 0.8})
    {
        const Cleanness half =
            measure_cleanness(in_order(shapes::with_noise_beyond(0, torus, noise * torus_spacing(torus), 5)), 1);
        EXPECT_TRUE(half.is_noisy_in_parts()) << half.noisy_places << ' ' << half.lower_roughness;
        EXPECT_TRUE(half.is_clean()) << "and the other signs miss it";
        const Cleanness seventh =
            measure_cleanness(in_order(shapes::with_noise_beyond(0.9, torus, noise * torus_spacing(torus), 5)), 1);
        EXPECT_TRUE(seventh.is_noisy_in_parts()) << seventh.noisy_part;
        EXPECT_LT(seventh.noisy_places, 0.1) << "too few, were they not side by side";
    }
    for (const int n : {400, 1000, 20'000})
        EXPECT_FALSE(measure_cleanness(in_order(shapes::torus(n, 1, 0.3, 3).points), 1).is_noisy_in_parts()) << n;
    for (const int n : {500, 3000})
        EXPECT_FALSE(measure_cleanness(in_order(shapes::box(n, {3, 2, 1}, 3).points), 1).is_noisy_in_parts()) << n;
}

TEST(Cleanness, NoiseThatComesAndGoesIsToldFromACloudThatIsCoarseAllOver)
{
    const Points torus = shapes::torus(20'000, 1, 0.3, 3).points;
    const double spacing = torus_spacing(torus);
    const auto expect_noisy = [](const Points& points, const std::string& what)
    {
        const Cleanness mixed = measure_cleanness(in_order(points), 1);
        EXPECT_TRUE(mixed.is_noisy_in_parts()) << what << ' ' << mixed.strays << ' ' << mixed.white_places << ' '
                                               << mixed.uneven_whiteness << ' ' << mixed.noisy_part;
    };
    const Points nearly_exact = shapes::with_noise(torus, 0.07 * spacing, 4);
    for (const double width : {3.0, 6.0}) // [spacings]
    {
        const auto is_in_stripe = [&](const Point& p) { return std::fmod(p.y() / (width * spacing) + 1e3, 2) < 1; };
        for (const double noise : {0.5, 1.0})
            expect_noisy(shapes::with_noise_where(is_in_stripe, nearly_exact, noise * spacing, 5),
                         "stripes of " + std::to_string(width) + " spacings, noise " + std::to_string(noise));
    }
    struct Spots
    {
        double width; // [spacings]
        unsigned of;  // of so many one is noisy
    };
    for (const Spots& spots : std::vector<Spots>{{4, 5}, {4, 10}, {6, 5}, {6, 10}, {10, 10}})
    {
        const auto is_in_spot = [&](const Point& p)
        {
            const Vector cell = (p / (spots.width * spacing)).array().floor() + 100;
            return scramble(std::uint64_t(cell.x() + 200 * cell.y() + 40'000 * cell.z())) % spots.of == 0;
        };
        expect_noisy(shapes::with_noise_where(is_in_spot, nearly_exact, spacing, 5),
                     "spots of " + std::to_string(spots.width) + " spacings, one in " + std::to_string(spots.of));
    }
    for (const double share : {0.1, 0.3})
        for (const double noise : {0.4, 0.8, 2.0})
            expect_noisy(shapes::with_noisy_share(share, torus, noise * spacing, 5),
                         "a share of " + std::to_string(share) + ", noise " + std::to_string(noise));
    const Points few = shapes::torus(1'000, 1, 0.3, 3).points;
    const Cleanness of_few =
        measure_cleanness(in_order(shapes::with_noisy_share(0.3, few, 0.8 * torus_spacing(few), 5)), 1);
    EXPECT_EQ(of_few.uneven_whiteness + of_few.strays, 0) << "they may be vertices of a part";
}

TEST(Cleanness, SignsOfNoiseThatComesAndGoesAddUpButWhereTheyAreOfOtherThings)
{
    Cleanness found;
    found.uneven_whiteness = 0.9;
    found.white_places = 0.05;
    found.strays = 0.005;
    EXPECT_TRUE(found.is_noisy_in_parts());
    for (double Cleanness::*const sign : {&Cleanness::white_places, &Cleanness::strays, &Cleanness::uneven_whiteness})
    {
        Cleanness without = found;
        without.*sign = 0;
        EXPECT_FALSE(without.is_noisy_in_parts());
    }
    found.strays = 0;
    found.lower_roughness = 0.02; // a part may be a coarse one if all is coarser than that
    found.noisy_part = 0.006;
    EXPECT_TRUE(found.is_noisy_in_parts());
    found.stacked = 0.3; // fins
    EXPECT_FALSE(found.is_noisy_in_parts());
}

TEST(Cleanness, OfNoPointsIsNone)
{
    const Cleanness none = measure_cleanness({}, 1);
    EXPECT_EQ(none.noisy_places, 0);
    EXPECT_FALSE(none.is_clean());
    EXPECT_FALSE(none.is_noisy_in_parts());
}

TEST(Cleanness, IsTheSameForAnyNumberOfThreads)
{
    const Points plate = sample_plate(1.5, 20);
    const Cleanness one = measure_cleanness(plate, 1), many = measure_cleanness(plate, 3);
    EXPECT_EQ(one.long_cells, many.long_cells);
    EXPECT_EQ(one.flat_neighbours, many.flat_neighbours);
    EXPECT_EQ(one.whiteness, many.whiteness);
    EXPECT_EQ(one.roughness, many.roughness);
    EXPECT_EQ(one.noisy_places, many.noisy_places);
    EXPECT_EQ(one.noisy_part, many.noisy_part);
    EXPECT_EQ(one.white_places, many.white_places);
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
        const Points samples = noisy ? shapes::with_noisy_copies(plate, 0.3, 4, 2) : plate;
        const double share = share_of_fine(samples, 0, samples.size());
        EXPECT_EQ(share > 0.95, !noisy);
        EXPECT_EQ(share < 0.05, noisy);
    }
}

TEST(ChooseScale, IsFineInASmallHoleOfACleanCloudAndCoarseInItsNoisyPart)
{
    // A bore of 3 spacings through a plate as thick, and another plate beside it that is noisy.
    constexpr double diameter = 3, thickness = 3, pi = 3.14159265358979323846;
    constexpr int around = 9, far_away = 80;
    Points samples;
    for (int layer = 0; layer < int(thickness); ++layer)
        for (int i = 0; i < around; ++i)
        {
            const double angle = 2 * pi / around * (i + 0.5 * layer);
            samples.emplace_back(diameter / 2 * std::cos(angle), diameter / 2 * std::sin(angle),
                                 layer + 0.5 - thickness / 2);
        }
    const std::size_t bore = samples.size();
    for (const Point& p : shapes::with_noisy_copies(sample_plate(thickness, 8), 0.3, 4, 2))
        samples.push_back(p + Vector(far_away, 0, 0));
    const std::size_t noisy = samples.size();
    for (const Point& p : sample_plate(thickness, 60))
        if (p.head<2>().norm() > diameter / 2 + 0.3)
            samples.push_back(p);
    EXPECT_GT(share_of_fine(samples, 0, bore), 0.5);
    EXPECT_LT(share_of_fine(samples, bore, noisy), 0.2);
}
