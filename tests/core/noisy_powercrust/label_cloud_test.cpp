#include "filter_amls/mesh/reconstruct_amls.h"
#include "filter_noisy_powercrust/labels/label_cloud.h"
#include "filter_noisy_powercrust/reconstruct.h"

#include "tests/checks.h"
#include "tests/flat_shapes.h"
#include "tests/lattices.h"
#include "tests/open_sheets.h"
#include "tests/scans.h"
#include "tests/shapes.h"

#include <recon/mesh/mismatch.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

using namespace recon;

namespace
{

constexpr double pi = 3.14159265358979323846;

bool says(const NoisyPowerCrust& crust, const std::string& words)
{
    return checks::says(crust.warnings, words);
}

NoisyPowerCrust reconstruct_opened(const Points& points)
{
    NoisyPowerCrustOptions options;
    options.open_holes = true;
    return reconstruct_noisy_power_crust(points, options);
}

} // namespace

TEST(NoisyPowerCrust, ACupOfThinNoisyWallsIsNotFilled)
{
    struct Case
    {
        double wall, noise, error;
        int samples_a_spot = 1;
        unsigned seed = 4;
    };
    // Of five samples a spot the points lie beside the filled cup as noise does, but votes object.
    for (const Case& one : {Case{1.2, 0.2, 0.2}, Case{1.5, 0.2, 0.1}, Case{2, 0.4, 0.1}, Case{2.5, 0.6, 0.1},
                            Case{0.8, 0.2, 0.15, 5, 14}, Case{0.8, 0.4, 0.2, 5}})
    {
        const shapes::Cup cup(one.wall);
        const NoisyPowerCrust crust =
            reconstruct_noisy_power_crust(shapes::noisy_copies(cup.points, one.noise, one.samples_a_spot, one.seed));
        const checks::MeshReport report = checks::examine_mesh(crust.mesh);
        EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
        EXPECT_NEAR(report.volume, cup.volume, one.error * cup.volume) << one.wall << ' ' << one.noise;
        if (one.wall <= 2 * one.noise)
        {
            EXPECT_TRUE(says(crust, "walls may have holes"));
        }
    }
}

// Between two rings of vertices a tube is one ball, and rounding decides which ring's samples vote for it.
TEST(NoisyPowerCrust, TubesOfRingsAreNotCut)
{
    for (const double thickness : {2.5, 3.0})
        for (const double major : {9, 15})
            for (const double noise : {0.0, 0.01})
            {
                const Points points =
                    shapes::with_noise(shapes::torus_of_rings(major, 0.5 * thickness).points, noise, 7);
                const NoisyPowerCrust crust = reconstruct_noisy_power_crust(points);
                EXPECT_EQ(crust.components, 1) << thickness << ' ' << major << ' ' << noise;
                EXPECT_EQ(crust.genus, 1) << thickness << ' ' << major << ' ' << noise;
                const AmlsReconstruction smooth = reconstruct_amls(points);
                EXPECT_EQ(smooth.genus, 1) << thickness << ' ' << major << ' ' << noise;
            }
}

// Everywhere nothing lies as near to a quadric as noise does.
TEST(NoisyPowerCrust, ThinTubesOfEvenPointsAreNoNoise)
{
    for (const double noise : {0.0, 0.1})
    {
        const Points points = shapes::with_noise(shapes::even_torus(30, 1, 3), noise, 101);
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(points);
        EXPECT_EQ(crust.components, 1) << noise;
        EXPECT_EQ(crust.genus, 1) << noise;
        EXPECT_FALSE(crust.denoised) << noise;
        EXPECT_EQ(reconstruct_amls(points).genus, 1) << noise;
    }
}

// What is cut off of each is no vertex: 2 to 5 % of the samples where the local scale takes spikes for noise.
TEST(NoisyPowerCrust, SpikesOfACleanBallAreNotCutOff)
{
    const Points points = shapes::spiky_ball(2.4, 1);
    const NoisyPowerCrust crust = reconstruct_noisy_power_crust(points);
    EXPECT_FALSE(crust.denoised);
    const checks::MeshReport report = checks::examine_mesh(crust.mesh);
    EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.genus(), 0);
    EXPECT_GT(crust.mesh.vertices.size(), 0.98 * double(points.size()));
}

// The first attempt takes the cup's walls for noise and completes the rod's ends.
TEST(NoisyPowerCrust, ACupBesideARodSampledOnItsRimsIsNotFilled)
{
    constexpr double noise = 0.3, radius = 14, length = 20;
    constexpr int corners = 60;
    const shapes::Cup cup(1.5, 24);
    Points points = shapes::with_noise(cup.points, noise, 4), rims;
    for (const double z : {0.0, length})
        flat_shapes::append_ring(rims, 72, 0, z, radius, corners);
    for (const Point& p : shapes::with_noisy_copies(rims, noise, 4, 5))
        points.push_back(p);
    const NoisyPowerCrust crust = reconstruct_noisy_power_crust(points);
    const checks::MeshReport report = checks::examine_mesh(crust.mesh);
    EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
    EXPECT_EQ(report.components, 2);
    EXPECT_GT(crust.completed, 0);
    const double rod = 0.5 * corners * std::sin(2 * pi / corners) * radius * radius * length;
    EXPECT_NEAR(report.volume, cup.volume + rod, 0.05 * (cup.volume + rod)); // 1.37 times as much with a full cup
}

// In slabs as wide as the noise says a face is found that is none, and the bracket came out with 1.11 to 1.29 of its
// volume.
TEST(NoisyPowerCrust, FacesThatTheSamplesRefuseAreSoughtInWiderSlabs)
{
    const Points bracket = flat_shapes::prism({{0, 0}, {1, 0}, {1, 0.2}, {0.2, 0.2}, {0.2, 0.8}, {0, 0.8}}, 0.5, 0.03);
    const double volume = 0.32 * 0.5;
    for (const auto& [noise, seed] : {std::pair(0.012, 8), std::pair(0.0137, 6)})
    {
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(shapes::with_noisy_copies(bracket, noise, 4, seed));
        const checks::MeshReport report = checks::examine_mesh(crust.mesh);
        EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
        EXPECT_GT(crust.completed, 0);
        EXPECT_NEAR(report.volume, volume, 0.03 * volume);
    }
}

// The rod's faces are found by the noise, a bore of the bevelled flange only in wider slabs.
TEST(NoisyPowerCrust, RimsWithLowBevelsAreSoughtInWiderSlabs)
{
    constexpr double noise = 0.003, bevel = 1.5 * noise, height = 0.15;
    Points points;
    const auto append_rims = [&](double x, double y, double radius, double narrowed, int corners)
    {
        for (const double z : {0.0, height})
        {
            flat_shapes::append_ring(points, x, y, z, radius - narrowed, corners);
            flat_shapes::append_ring(points, x, y, z == 0 ? bevel : height - bevel, radius, corners);
        }
    };
    append_rims(0, 0, 0.45, bevel, 150);
    append_rims(0, 0, 0.2, -bevel, 70);
    for (int k = 0; k < 4; ++k)
        append_rims(0.33 * std::cos(pi / 2 * k), 0.33 * std::sin(pi / 2 * k), 0.05, -bevel, 24);
    for (const double z : {0.0, 0.1})
        flat_shapes::append_ring(points, 1, 0, z, 0.3, 120);
    NoisyPowerCrustOptions options;
    options.keep_components = KeepComponents::all;
    const NoisyPowerCrust crust =
        reconstruct_noisy_power_crust(shapes::with_noisy_copies(points, noise, 4, 2), options);
    const checks::MeshReport report = checks::examine_mesh(crust.mesh);
    EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
    EXPECT_EQ(report.components, 2);
    EXPECT_EQ(report.genus(), 5); // 4 in slabs of one width
}

TEST(NoisyPowerCrust, SaysThatWallsSeemLost)
{
    const auto says_so = [](double wall, double noise)
    {
        return says(reconstruct_noisy_power_crust(shapes::with_noise(shapes::Cup(wall).points, noise, 4)),
                    "walls may have been taken for noise");
    };
    EXPECT_TRUE(says_so(0.8, 0.2)); // filled: at no noise assumed are its walls found
    EXPECT_FALSE(says_so(2.5, 0.3));
}

// Most points lie farther from the surface than their spacing, and a third of the surface has none.
TEST(NoisyPowerCrust, AnOpenNoisyScanHasLostNoWalls)
{
    Points half;
    for (const Point& p : shapes::sphere(6000, 1, 2).points)
        if (p.z() > 0)
            half.push_back(p);
    Points scan = shapes::with_noisy_copies(half, 0.02, 4, 3);
    const std::size_t count = scan.size();
    shapes::Random random(7);
    for (const double outliers : {0.0, 0.05})
    {
        while (double(scan.size()) < (1 + outliers) * double(count))
        {
            const Point place = shapes::draw_vector([&] { return shapes::uniform(random); });
            scan.emplace_back(3 * place.x() - 1.5, 3 * place.y() - 1.5, 1.7 * place.z() - 0.1);
        }
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(scan);
        const checks::MeshReport report = checks::examine_mesh(crust.mesh);
        EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
        EXPECT_NEAR(report.volume, 2 * pi / 3, 0.12); // -0.06 to 0.09 on ten other scans
        EXPECT_FALSE(says(crust, "walls may have been taken for noise")) << outliers;
    }
}

TEST(NoisyPowerCrust, PlanesOfALatticeAreNoLostWalls)
{
    const NoisyPowerCrust crust = reconstruct_noisy_power_crust(shapes::half_torus_on_lattice());
    EXPECT_EQ(crust.genus, 0);
    EXPECT_TRUE(crust.warnings.empty()) << crust.warnings.front();
}

// A ball before a wall as a depth camera sees them, noise growing with the square of the depth. Votes object to any way
// of closing it; less noise, as for a lost wall, would make lace of the wall.
TEST(NoisyPowerCrust, AnOpenSceneIsNoLostWall)
{
    constexpr int rows = 120, columns = 160;
    constexpr double focal = 140, wall = 4, radius = 0.6;
    const Point centre(0, 0, 2);
    Points points;
    std::vector<double> sigma;
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j)
        {
            const Vector ray((j - columns / 2) / focal, (i - rows / 2) / focal, 1);
            const double along = ray.dot(centre), squared = ray.squaredNorm(),
                         inside = along * along - squared * (centre.squaredNorm() - radius * radius);
            const double depth = inside > 0 ? (along - std::sqrt(inside)) / squared : wall;
            points.push_back(depth * ray);
            sigma.push_back(0.0024 * depth * depth);
        }
    const Points noise = shapes::with_noise(Points(points.size(), Point::Zero()), 1, 3);
    for (std::size_t i = 0; i < points.size(); ++i)
        points[i] *= 1 + sigma[i] * noise[i].z() / points[i].z();
    const NoisyPowerCrust crust = reconstruct_noisy_power_crust(points);
    const checks::MeshReport report = checks::examine_mesh(crust.mesh);
    EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
    // The ball, and the wall with a hole where the ball hides it.
    EXPECT_EQ(report.components, 2);
    EXPECT_EQ(report.genus(), 1);
    EXPECT_GT(
        std::count_if(crust.mesh.vertices.begin(), crust.mesh.vertices.end(), [](const Point& p) { return p.z() < 2; }),
        100);
    EXPECT_FALSE(says(crust, "left hollow"));
    EXPECT_TRUE(says(crust, "given a back"));
    EXPECT_LT(crust.violated_votes, 0.05); // 0.39 without backs
}

// Only the underside of a cup's ground was seen: the outside reached it from above.
TEST(NoisyPowerCrust, GroundsSeenFromOneSideGetABack)
{
    for (const double noise : {0.0, 0.1, 0.2})
    {
        const shapes::Cup cup(4, 32);
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(shapes::with_noise(cup.seen_above(4), noise, 3));
        EXPECT_EQ(crust.genus, 0) << noise;
        EXPECT_NEAR(checks::examine_mesh(crust.mesh).volume / cup.volume, 1, 0.08) << noise; // 0.89 without
        EXPECT_TRUE(says(crust, "given a back")) << noise;
    }
}

TEST(NoisyPowerCrust, AFinOfWhichOneSideWasSeenIsKept)
{
    for (const double noise : {0.0, 0.1, 0.2})
    {
        const shapes::FinnedBall ball = shapes::finned_ball(4);
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(shapes::with_noise(ball.samples.points, noise, 4));
        EXPECT_EQ(crust.components, 1);
        EXPECT_EQ(crust.genus, 0) << noise;
        EXPECT_LT(measure_missed_points(ball.fin_points(), crust.mesh), 0.05)
            << noise; // half of it and more without a back
        EXPECT_TRUE(says(crust, "given a back")) << noise;
    }
}

TEST(NoisyPowerCrust, AFinIsKeptThoughItsSlabHasAHandle)
{
    // More than 2 % of the samples: then backs stay only if they have no more handles, and these have one.
    const shapes::FinnedBall ball = shapes::finned_ball(8);
    const NoisyPowerCrust crust = reconstruct_noisy_power_crust(shapes::with_noise(ball.samples.points, 0.1, 4));
    EXPECT_LT(measure_missed_points(ball.fin_points(), crust.mesh), 0.05); // 0.8 without
}

// Which was hollowed out by a back behind all of it (0.56 and 0.43 of its volume): its sheet has an inside on both
// sides.
TEST(NoisyPowerCrust, ABallWithASheetWithinIsNoOpenSheet)
{
    for (const std::uint64_t seed : {1, 2})
    {
        Points points = shapes::sphere(8000, 1, seed).points;
        const auto ring = [](double u, double v)
        {
            const double radius = std::sqrt(0.16 + 0.75 * u), angle = 2 * M_PI * v;
            return Point(radius * std::cos(angle), radius * std::sin(angle), 0.3);
        };
        for (const Point& p : shapes::sheet(1500, ring, seed + 20).points)
            points.push_back(p);
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(points);
        EXPECT_EQ(crust.genus, 0) << seed;
        EXPECT_NEAR(checks::examine_mesh(crust.mesh).volume, 4 * M_PI / 3, 0.05 * 4 * M_PI / 3) << seed;
    }
}

TEST(NoisyPowerCrust, OpenSheetsOfExactPointsKeepThem)
{
    open_sheets::expect_exact_points_kept(reconstruct_opened);
}

TEST(NoisyPowerCrust, NoisyOpenSheetsComeOutWhole)
{
    open_sheets::expect_noisy_ones_whole(reconstruct_opened);
}

TEST(DescribeLostSheets, AdvisesWhatHasNotBeenTried)
{
    const auto has = [](const std::string& text, const char* words) { return text.find(words) != std::string::npos; };
    EXPECT_TRUE(describe_lost_sheets(0, 0, Denoise::off, 1000).empty());
    EXPECT_TRUE(has(describe_lost_sheets(0.2, 5, Denoise::automatic, 1000), "given a back"));
    for (const Denoise denoise : {Denoise::automatic, Denoise::on, Denoise::off})
        for (const std::size_t points : {1000, 2'000'000})
        {
            const std::string text = describe_lost_sheets(0.2, 0, denoise, points);
            EXPECT_TRUE(has(text, "20 % of the samples")) << text;
            EXPECT_TRUE(has(text, "selected_only")) << text;
            EXPECT_EQ(has(text, "set denoise"), denoise == Denoise::off) << text;
            EXPECT_EQ(has(text, "thin the points"), points > 1'000'000) << text;
        }
}

TEST(NoisyPowerCrust, FinsAreNoSlabOfNoise)
{
    const shapes::HeatSink sink(8, 2, 2.6, 17, 33, 5);
    for (const double noise : {0.0, 0.1, 0.2})
    {
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(shapes::with_noise(sink.points, noise, 2));
        const checks::MeshReport report = checks::examine_mesh(crust.mesh);
        EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
        EXPECT_EQ(crust.denoised, noise > 0);
        EXPECT_NEAR(crust.noise, noise, 0.03) << noise; // 4.6 when the whole stack was taken for noise
        EXPECT_NEAR(report.volume / sink.volume, 1, 0.03) << noise;
        EXPECT_EQ(report.genus(), 0) << noise;
    }
}

TEST(NoisyPowerCrust, NormalsSettleWhichVotesOfFinsAreRight)
{
    for (const auto& [wall, gap] : {std::pair{2.3, 1.5}, {1.7, 2.3}, {1.5, 2.0}})
    {
        const shapes::HeatSink sink(8, wall, gap, 14, 25, 4);
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(sink.points);
        EXPECT_FALSE(crust.denoised);
        EXPECT_EQ(crust.genus, 0) << wall << ' ' << gap; // 1 without
        EXPECT_NEAR(checks::examine_mesh(crust.mesh).volume / sink.volume, 1, 0.03);
    }
}

TEST(NoisyPowerCrust, FinsNearerThanTheWeightsAreWideStayApart)
{
    const shapes::HeatSink sink(12, 1.7, 1.7, 14, 27, 3);
    for (const double noise : {0.0, 0.1})
    {
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(shapes::with_noise(sink.points, noise, 2));
        EXPECT_NEAR(checks::examine_mesh(crust.mesh).volume / sink.volume, 1, 0.03) << noise;
        EXPECT_GE(crust.samples, 0.9 * double(sink.points.size())) << noise;
    }
}

// Walls of little more than one spacing, with noise of a third of it: chance has a say.
TEST(NoisyPowerCrust, OpensLidsOfCupsThatAreFilledAtAnyNoise)
{
    int opened = 0;
    for (const double noise : {0.3, 0.4})
        for (unsigned seed = 1; seed <= 6; ++seed)
        {
            const shapes::Cup cup(1.2);
            const NoisyPowerCrust crust = reconstruct_noisy_power_crust(shapes::with_noise(cup.points, noise, seed));
            const checks::MeshReport report = checks::examine_mesh(crust.mesh);
            EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
            const bool is_right = std::abs(report.volume - cup.volume) < 0.2 * cup.volume;
            opened += is_right && says(crust, "left hollow");
        }
    EXPECT_GE(opened, 5) << "of 12"; // 6; with seeds 11 to 40 36 of 60 are right, 37 with round windows
}

/// Open at both ends, so that lids fill it.
struct PipeCase
{
    double wall, noise; ///< [spacings]
    int seed;
};

// Half the noise missed nearly as many points as all of it, while no more votes objected, so the search for walls was
// given up, and of some with more noise the surface was taken that lay between the walls: 3.2 to 3.8 of the volume.
TEST(NoisyPowerCrust, PipesOfThinNoisyWallsAreNotFilled)
{
    for (const auto& [wall, noise, seed] : {PipeCase{1.5, 0.3, 721}, {1.5, 0.3, 725}, {1.3, 0.2, 719}})
    {
        const shapes::Pipe pipe = shapes::pipe(wall, noise, seed);
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(pipe.noisy);
        EXPECT_NEAR(checks::examine_mesh(crust.mesh).volume / pipe.volume, 1, 0.2) << seed;
        EXPECT_FALSE(says(crust, "out of register")) << seed;
    }
}

// Whose noise is told of each view: of the first the surface was lace that enclosed 0.6 of the volume, between those of
// the second it wove, with 5 % of the votes against it.
TEST(NoisyPowerCrust, ViewsOutOfRegisterAreOneSurface)
{
    constexpr double volume = 2 * pi * pi * 0.4 * 0.4;
    for (const int seed : {2, 4})
    {
        const Points points = shapes::torus_out_of_register(seed).points;
        const NoisyPowerCrust crust = reconstruct_noisy_power_crust(points);
        EXPECT_EQ(crust.components, 1) << seed;
        EXPECT_EQ(crust.genus, 1) << seed;
        EXPECT_LT(crust.violated_votes, 0.004) << seed;
        EXPECT_NEAR(checks::examine_mesh(crust.mesh).volume, volume, 0.2 * volume) << seed;
        EXPECT_TRUE(says(crust, "out of register")) << seed;
    }
    NoisyPowerCrustOptions given;
    given.noise = 0.02;
    EXPECT_FALSE(
        says(reconstruct_noisy_power_crust(shapes::torus_out_of_register(4).points, given), "out of register"));
}
