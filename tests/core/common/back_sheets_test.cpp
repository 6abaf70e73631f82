#include <recon/crust/back_sheets.h>

#include "tests/checks.h"
#include "tests/shapes.h"

#include <recon/mesh/crust_mesh.h>
#include <recon/mesh/mismatch.h>
#include <recon/progress.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

using namespace recon;

namespace
{

/// A shallow vault scanned from above, in a unit frame: nothing behind it.
struct Scan
{
    Points samples;
    Vectors normals;
};

Scan scan_vault(int side)
{
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> jitter(-0.25, 0.25);
    Scan result;
    const double spacing = 0.7 / side, radius = 0.5;
    for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j)
        {
            const double x = (i - side / 2.0 + jitter(random)) * spacing,
                         y = (j - side / 2.0 + jitter(random)) * spacing;
            const double z = std::sqrt(radius * radius - x * x);
            result.samples.emplace_back(x, y, z);
            result.normals.push_back(Vector(x, 0, z) / radius);
        }
    return result;
}

LabelledBalls label(const Scan& scan)
{
    PhaseTimes times;
    return label_polar_balls(scan.samples, scan.normals, {}, times);
}

auto normals_of(const Scan& scan)
{
    return [&](const Progress&) { return scan.normals; };
}

} // namespace

TEST(BackSheets, ASheetWithTheOutsideOnBothSidesIsLost)
{
    const Scan scan = scan_vault(40);
    LabelledBalls labelled = label(scan);
    EXPECT_LT(find_lost_sheets(scan.samples, labelled, true, 1).share, 0.2);
    std::fill(labelled.labels.begin(), labelled.labels.end(), Side::outer);
    EXPECT_EQ(find_lost_sheets(scan.samples, labelled, true, 1).share, 1);
    EXPECT_EQ(find_lost_sheets(scan.samples, labelled, false, 1).share, 1);
}

TEST(BackSheets, ThoseApartDoNotHangTogether)
{
    // A vault without its middle strips: three pieces, the same for any number of threads.
    Scan scan = scan_vault(40), pieces;
    for (std::size_t i = 0; i < scan.samples.size(); ++i)
        if (std::abs(std::abs(scan.samples[i].y()) - 0.12) > 0.06)
        {
            pieces.samples.push_back(scan.samples[i]);
            pieces.normals.push_back(scan.normals[i]);
        }
    LabelledBalls labelled = label(pieces);
    std::fill(labelled.labels.begin(), labelled.labels.end(), Side::outer);
    for (const int threads : {1, 3})
    {
        const LostSheets lost = find_lost_sheets(pieces.samples, labelled, true, threads);
        EXPECT_EQ(lost.share, 1);
        EXPECT_NEAR(lost.largest, 0.39, 0.03); // a strip 0.17 wide of 0.46
    }
}

TEST(BackSheets, ABackMakesASlabOfIt)
{
    Scan scan = scan_vault(40);
    const Points front = scan.samples;
    LostSheets all;
    all.around.assign(front.size(), 1);
    const int added = back_sheets(all, scan.samples, scan.normals, 1);
    EXPECT_EQ(added, int(front.size()));
    ASSERT_EQ(scan.samples.size(), front.size() + std::size_t(added));
    const LabelledBalls labelled = label(scan);
    const TriangleMesh crust = triangulate_polygons(list_crust_polygons(labelled.regular, labelled.labels));
    const checks::MeshReport report = checks::examine_mesh(crust);
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.genus(), 0);
    EXPECT_LT(measure_missed_points(front, crust), 0.01);
    EXPECT_LT(find_lost_sheets(scan.samples, labelled, true, 1).share, 0.05);
    EXPECT_GT(report.volume, 0); // outward
}

TEST(BackSheets, NoBackWhereAnotherSheetIs)
{
    Scan scan = scan_vault(30);
    const std::size_t front = scan.samples.size();
    const double spacing = 0.7 / 30;
    for (std::size_t i = 0; i < front; ++i)
    {
        scan.samples.push_back(scan.samples[i] - 3 * spacing * scan.normals[i]);
        scan.normals.push_back(-scan.normals[i]);
    }
    LostSheets lost;
    lost.around.assign(scan.samples.size(), 0);
    std::fill_n(lost.around.begin(), front, 1.0);
    EXPECT_LT(back_sheets(lost, scan.samples, scan.normals, 1), int(front / 20));
}

TEST(BackSheets, AFinOfWhichOneSideWasSeenGetsABackAlone)
{
    const shapes::FinnedBall ball = shapes::finned_ball(3);
    const UnitFrame frame(ball.samples.points);
    const Scan scan{frame.to_unit(ball.samples.points), ball.samples.normals};
    LabelledBalls labelled = label(scan);
    LostSheets lost = find_lost_sheets(scan.samples, labelled, true, 1);
    EXPECT_LT(lost.share, bearable_lost);
    const double n = double(scan.samples.size());
    EXPECT_NEAR(lost.largest * n, ball.fin, 0.3 * ball.fin);

    // Samples without an inside here and there, as at rims of scans, get none.
    for (std::size_t i = 0; i < scan.samples.size(); ++i)
        if (scan.samples[i].x() < -0.2)
            lost.around[i] = 0.3;
    PhaseTimes times;
    const auto backed = label_with_backs(lost, scan.samples, true, normals_of(scan), labelled, {}, times);
    ASSERT_TRUE(backed);
    EXPECT_EQ(backed->samples.size(), scan.samples.size() + std::size_t(backed->backs));
    EXPECT_NEAR(backed->backs, ball.fin, 0.2 * ball.fin);
    const Points fin(scan.samples.end() - ball.fin, scan.samples.end());
    const auto missed = [&](const LabelledBalls& balls)
    { return measure_missed_points(fin, triangulate_polygons(list_crust_polygons(balls.regular, balls.labels))); };
    EXPECT_GT(missed(labelled), 0.3);
    EXPECT_LT(missed(backed->labelled), 0.05);
    EXPECT_TRUE(find_lost_sheets(backed->samples, backed->labelled, true, 1).around.empty());

    labelled.violated_votes = 0; // fewer than with backs
    EXPECT_FALSE(label_with_backs(lost, scan.samples, true, normals_of(scan), labelled, {}, times));
    labelled.violated_votes = 1;
    lost.share = 1; // all over the scene
    EXPECT_FALSE(label_with_backs(lost, scan.samples, true, normals_of(scan), labelled, {}, times));
}

TEST(BackSheets, NoBackWhereTheCrustMissesNothing)
{
    const OrientedSamples sphere = shapes::sphere(5000, 0.45, 3);
    const Scan scan{sphere.points, sphere.normals};
    const LabelledBalls labelled = label(scan);
    LostSheets lost = find_lost_sheets(scan.samples, labelled, true, 1);
    EXPECT_TRUE(lost.around.empty());
    PhaseTimes times;
    EXPECT_FALSE(label_with_backs(lost, scan.samples, true, normals_of(scan), labelled, {}, times));
    for (const Point& p : scan.samples)
        lost.around.push_back(p.z() > 0.4);
    lost.largest = 0.05;
    bool asks_normals = false;
    const auto list_normals = [&](const Progress&)
    {
        asks_normals = true;
        return scan.normals;
    };
    EXPECT_FALSE(label_with_backs(lost, scan.samples, true, list_normals, labelled, {}, times));
    EXPECT_FALSE(asks_normals); // known before labels are found again
}
