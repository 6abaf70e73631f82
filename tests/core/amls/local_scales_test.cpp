#include "filter_amls/fits/local_scales.h"

#include "tests/shapes.h"

#include <recon/noise/noise.h>
#include <recon/search/spatial_order.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace recon;

namespace
{

struct Widths
{
    Points seeds;
    std::vector<double> widths;
};

Widths choose(const Points& points)
{
    Points sorted;
    for (const int i : order_spatially(points).order)
        sorted.push_back(points[i]);
    const NoiseEstimate noise = estimate_noise(sorted, {});
    const BlockSearch search(sorted);
    const LocalScales scales = choose_widths(sorted, search, noise, 1, {});
    Widths result{noise.seeds(), {}};
    for (const LocalScale& scale : scales.at_seed)
        result.widths.push_back(scale.width);
    return result;
}

double median(std::vector<double> values)
{
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
    return values[values.size() / 2];
}

} // namespace

TEST(LocalScales, WidthsFollowTheCurvature)
{
    // Two spheres of the same density: with the risks of too few seeds pooled to tell bias from noise, or of all of
    // them, the widths would be alike.
    double mean = 0;
    for (const unsigned seed : {1u, 2u, 3u, 4u})
    {
        Points points = shapes::sphere(20000, 1, seed).points;
        for (const Point& p : shapes::sphere(1250, 0.25, seed).points)
            points.push_back(p + Point(3, 0, 0));
        const Widths found = choose(shapes::with_noise(points, 0.02, seed + 10));
        std::vector<double> large, small;
        for (std::size_t i = 0; i < found.seeds.size(); ++i)
            (found.seeds[i].x() > 2 ? small : large).push_back(found.widths[i]);
        ASSERT_FALSE(small.empty());
        mean += median(large) / median(small) / 4;
    }
    EXPECT_GT(mean, 1.27); // 1.06 from single seeds, 1.21 from five at a time, 1 from all
}

TEST(LocalScales, NoisyPartsAreAsWideBesideCleanOnes)
{
    // Clean parts bear the narrowest width only.
    const double sigma = std::sqrt(4 * M_PI * M_PI * 0.3 / 20000);
    const Points exact = shapes::torus(20000, 1, 0.3, 5).points;
    const auto median_width = [](const Widths& found, double from)
    {
        std::vector<double> noisy;
        for (std::size_t i = 0; i < found.seeds.size(); ++i)
            if (found.seeds[i].x() > from)
                noisy.push_back(found.widths[i]);
        return median(noisy);
    };
    const Widths whole = choose(shapes::with_noise(exact, sigma, 6));
    const auto ratio = [&](double from)
    {
        const Widths part = choose(shapes::with_noise_beyond(from, exact, sigma, 6));
        return median_width(part, from) / median_width(whole, from);
    };
    EXPECT_NEAR(ratio(0), 1, 0.15);
    EXPECT_NEAR(ratio(0.9), 1, 0.25); // a seventh; 0.59 if its rim is taken for cleaner
}

/// A noisy cloud whose sides are known.
class CloudWithSides
{
public:
    /// \param exact in spacings; the noise is 0.4 of them. \param side the true normal at a place.
    template <class Side>
    CloudWithSides(const Points& exact, const Side& side)
    {
        const Points unsorted = shapes::with_noise(exact, 0.4, 7);
        for (const int i : order_spatially(unsorted).order)
        {
            points_.push_back(unsorted[i] / length);
            normals_.push_back(side(exact[i]));
        }
        search_ = BlockSearch(points_);
    }

    /// Median width of the seeds with a place that counts [spacings].
    template <class Counts>
    double median_fit_width(double clearance, const Counts& counts) const
    {
        const NoiseEstimate noise = estimate_noise(points_, {});
        Vectors facing;
        for (const Point& seed : noise.seeds())
            facing.push_back(normals_[search_.nearest(seed)]);
        const FitSamples samples{points_, search_, std::vector<double>(points_.size(), 1), normals_};
        return median_of(choose_fit_widths(samples, facing, noise, clearance, 1), counts);
    }
    double median_width() const
    {
        return median_of(choose_widths(points_, search_, estimate_noise(points_, {}), 1),
                         [](const Point&) { return true; });
    }

private:
    static constexpr double length = 60; // spacings to the unit

    template <class Counts>
    static double median_of(const LocalScales& scales, const Counts& counts)
    {
        std::vector<double> widths;
        for (std::size_t i = 0; i < scales.at_seed.size(); ++i)
            if (counts(Point(length * scales.seeds.seeds()[i])))
                widths.push_back(length * scales.at_seed[i].width);
        return median(widths);
    }

    Points points_;
    Vectors normals_;
    BlockSearch search_;
};

// Two sheets that face away from each other.
TEST(LocalScales, TheOtherSideOfAWallIsNoBend)
{
    constexpr double apart = 6; // spacings
    Points exact;
    for (int i = 0; i < 60; ++i)
        for (int j = 0; j < 60; ++j)
            for (const double z : {0.0, apart})
                exact.emplace_back(i, j, z);
    const CloudWithSides wall(exact, [](const Point& p) { return Vector(0, 0, p.z() > 0 ? 1 : -1); });
    EXPECT_GT(wall.median_fit_width(1.5, [](const Point&) { return true; }), 1.5 * wall.median_width());
}

// Nor is the face across an edge, but where it is so near that it counts.
TEST(LocalScales, TheFaceAcrossAnEdgeIsNoBend)
{
    Points exact;
    for (int i = 0; i < 60; ++i)
        for (int j = 0; j < 60; ++j)
        {
            exact.emplace_back(i, j + 0.5, 0);
            exact.emplace_back(i, 0, -j - 0.5);
        }
    const CloudWithSides edge(exact, [](const Point& p) { return p.y() > 0 ? Vector(0, 0, 1) : Vector(0, -1, 0); });
    const auto depth = [](const Point& p) { return std::max(std::abs(p.y()), std::abs(p.z())); };
    const auto near_by_far = [&](double clearance)
    {
        const auto is_near = [&](const Point& p) { return depth(p) < 5; };
        const auto is_far = [&](const Point& p) { return depth(p) > 20 && depth(p) < 40; };
        return edge.median_fit_width(clearance, is_near) / edge.median_fit_width(clearance, is_far);
    };
    EXPECT_GT(near_by_far(0.35), 0.65);
    EXPECT_LT(near_by_far(1.5), 0.6);
}
