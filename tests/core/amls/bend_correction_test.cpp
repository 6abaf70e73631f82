#include "filter_amls/fits/bend_correction.h"

#include "tests/shapes.h"

#include <gtest/gtest.h>

using namespace recon;

namespace
{

constexpr double width = 0.1, sigma = 0.01, effective = 40, between_fits = 0.0025;

/// Anchors on a plane, a width apart at most, whose two fits differ by noise alone, for x > 0.5 by `bend` too.
struct Patch
{
    std::vector<Anchor> anchors;
    std::vector<TwoWidths> fits;
    std::vector<FitStart> starts;
};

Patch make_patch(double bend, double thickness)
{
    shapes::Random random(3);
    std::normal_distribution<double> normal;
    Patch patch;
    for (double x = -1; x < 1; x += 0.06)
        for (double y = -0.5; y < 0.5; y += 0.06)
        {
            const Point p(x, y, 0);
            TwoWidths two;
            two.position = p;
            two.wide.effective = effective;
            two.narrow.c[0] = between_fits * normal(random) + (x > 0.5 ? bend : 0);
            two.comparable = true;
            patch.fits.push_back(two);
            patch.starts.push_back({p, Vector::UnitZ(), width, thickness});
            patch.anchors.push_back({p, Vector::UnitZ(), {}, 1, width});
        }
    correct_bends(patch.anchors, patch.fits, patch.starts, 1);
    return patch;
}

/// Mean height of the anchors beyond |x| > 0.7 on one side.
double mean_height(const Patch& patch, double side)
{
    double sum = 0;
    int count = 0;
    for (const Anchor& a : patch.anchors)
        if (side * a.position.x() > 0.7)
        {
            sum += a.position.z();
            ++count;
        }
    return sum / count;
}

} // namespace

TEST(BendCorrection, MovesWhereTheWidthsDisagreeAndNowhereElse)
{
    const double bend = 4 * between_fits;
    const Patch patch = make_patch(bend, sigma);
    EXPECT_GT(mean_height(patch, 1), bend);
    EXPECT_LT(mean_height(patch, 1), 1.5 * bend);
    EXPECT_NEAR(mean_height(patch, -1), 0, 0.1 * between_fits);
    int narrowed_plain = 0, wide_bent = 0;
    for (const Anchor& a : patch.anchors)
    {
        narrowed_plain += a.position.x() < 0.2 && a.width < 0.9 * width;
        wide_bent += a.position.x() > 0.7 && a.width > 0.9 * width;
    }
    EXPECT_EQ(wide_bent, 0);
    EXPECT_LT(narrowed_plain, int(patch.anchors.size()) / 50);
}

TEST(BendCorrection, LeavesFitsAloneThatAreNarrowerThanTheNoiseIsThick)
{
    // Differences of 1.4 sigma are noise in full, and the narrower width is 1.2 sigma.
    const Patch patch = make_patch(4 * between_fits, between_fits);
    EXPECT_GT(mean_height(patch, 1), 0.5 * between_fits);
    const double thick = 0.05;
    Patch noisy;
    shapes::Random random(4);
    std::normal_distribution<double> normal;
    for (double x = -1; x < 1; x += 0.06)
    {
        TwoWidths two;
        two.position = Point(x, 0, 0);
        two.wide.effective = 4;
        two.narrow.c[0] = thick * normal(random) + (x > 0.5 ? 4 * thick : 0);
        two.comparable = true;
        noisy.fits.push_back(two);
        noisy.starts.push_back({two.position, Vector::UnitZ(), width, thick});
        noisy.anchors.push_back({two.position, Vector::UnitZ(), {}, 1, width});
    }
    correct_bends(noisy.anchors, noisy.fits, noisy.starts, 1);
    EXPECT_EQ(mean_height(noisy, 1), 0);
}
