#include "filter_amls/mesh/reconstruct_amls.h"
#include "filter_amls/mesh/thin_walls.h"
#include "filter_amls/normals/outward_normals.h"
#include "filter_amls/surface/sample_surface.h"
#include "filter_amls/surface/surface.h"

#include <recon/mesh/crust_mesh.h>
#include <recon/search/spatial_order.h>

#include "tests/checks.h"
#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <optional>
#include <utility>

using namespace recon;

namespace
{

struct Labelled
{
    Points samples;
    Vectors normals; ///< Of their AMLS surface.
    LabelledBalls plain;
    int asked = 0; ///< How often the normals were wanted.

    std::optional<LabelledBalls> label_again(double stacked)
    {
        PhaseTimes times;
        const auto list_normals = [&](const Progress&)
        {
            ++asked;
            return normals;
        };
        return label_thin_walls(samples, stacked, list_normals, {}, plain, times);
    }
};

Labelled label(const Points& points)
{
    const UnitFrame frame(points);
    const Points samples = frame.to_unit(points_at(order_spatially(points).order, points));
    PhaseTimes times;
    return {samples, list_surface_normals(samples, build_amls_surface(samples), 1),
            label_polar_balls(samples, {}, {}, times)};
}

int count_handles(const LabelledBalls& labelled)
{
    return measure_closed_topology(triangulate_polygons(list_crust_polygons(labelled.regular, labelled.labels)))
        .genus();
}

} // namespace

TEST(LabelThinWalls, NormalsTakeHandlesAway)
{
    for (const auto& [wall, gap] : {std::pair{2.3, 1.5}, {2.3, 1.7}, {1.7, 2.3}})
    {
        Labelled fins = label(shapes::HeatSink(8, wall, gap, 14, 25, 4).points);
        ASSERT_GT(count_handles(fins.plain), 0);
        EXPECT_FALSE(fins.label_again(0.1)); // solid, with bores that normals may close
        EXPECT_EQ(fins.asked, 0);
        const auto better = fins.label_again(0.5);
        ASSERT_TRUE(better) << wall << ' ' << gap;
        EXPECT_EQ(count_handles(*better), 0) << wall << ' ' << gap;
        EXPECT_LT(better->violated_votes, 0.5 * fins.plain.violated_votes);
    }
}

TEST(LabelThinWalls, RealHandlesAreNotAskedAbout)
{
    Labelled torus = label(shapes::torus(2000, 1, 0.3, 3).points);
    EXPECT_FALSE(torus.label_again(0.5)); // no vote objects
    EXPECT_EQ(torus.asked, 0);
}

TEST(LabelThinWalls, NormalsThatViolateMoreAreNotBelieved)
{
    Labelled fins = label(shapes::HeatSink(8, 2.3, 1.5, 14, 25, 4).points);
    for (Vector& normal : fins.normals)
        normal = Vector(1, 0, 0);
    EXPECT_FALSE(fins.label_again(0.5));
    EXPECT_EQ(fins.asked, 1);
}

// Half of the handles gone, or all, vouch for labels that violate little fewer votes.
TEST(LabelThinWalls, FewHandlesLeftMakeUpForVotes)
{
    Labelled fins = label(shapes::HeatSink(8, 2.3, 1.5, 14, 25, 4).points);
    const auto better = fins.label_again(0.5);
    ASSERT_TRUE(better);
    ASSERT_EQ(count_handles(*better), 0);
    fins.plain.violated_votes = better->violated_votes / 0.7;
    EXPECT_TRUE(fins.label_again(0.5));
    fins.plain.violated_votes = better->violated_votes / 0.9;
    EXPECT_FALSE(fins.label_again(0.5));
}

// See NoisyPowerCrust.PipesOfThinNoisyWallsAreNotFilled.
TEST(ReconstructAmls, PipesOfThinNoisyWallsAreNotFilled)
{
    for (const int seed : {722, 725})
    {
        const shapes::Pipe pipe = shapes::pipe(1.5, 0.3, seed);
        const TriangleMesh mesh = reconstruct_amls(pipe.noisy).mesh;
        EXPECT_NEAR(checks::examine_mesh(mesh).volume / pipe.volume, 1, 0.2) << seed;
        EXPECT_GT(checks::share_facing(find_outward_normals(pipe.noisy).normals, pipe.samples.normals), 0.9) << seed;
    }
}
