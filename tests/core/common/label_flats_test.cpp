#include <recon/bare_faces/label_flats.h>

#include "tests/flat_shapes.h"
#include "tests/shapes.h"

#include <recon/bare_faces/label_noisy_flats.h>
#include <recon/search/spatial_order.h>

#include <gtest/gtest.h>

using namespace recon;

namespace
{

const Points samples = shapes::sphere(300, 1, 1).points;

/// Labels of the samples alone, as if they violated so many votes.
LabelledBalls label_as(double violated)
{
    PhaseTimes times;
    LabelledBalls result = label_polar_balls(samples, {}, {}, times);
    result.violated_votes = violated;
    return result;
}

/// What labels of the samples with others would be: none, or how many were added.
int added_if(double violated_without, double violated_with, int added)
{
    FlatCompletion completion;
    completion.points = Points(std::size_t(added), Point::Zero());
    const auto label = [&](const Points& all, const Vectors& normals, double)
    {
        EXPECT_TRUE(normals.empty());
        EXPECT_EQ(all.size(), samples.size() + std::size_t(added));
        return label_as(violated_with);
    };
    const auto found = label_with_flats(
        samples, [&] { return completion; }, violated_without, label);
    return found ? found->added : 0;
}

} // namespace

TEST(LieAlongLines, TellsRimsFromSheets)
{
    const auto lie = [](Points points)
    {
        points = points_at(order_input(points).order, points);
        return lie_along_lines(points, BlockSearch(points, 1));
    };
    EXPECT_TRUE(lie(shapes::with_noisy_copies(flat_shapes::flange(), 0.004, 4, 1)));
    EXPECT_FALSE(lie(samples));
    EXPECT_FALSE(lie(shapes::with_noisy_copies(shapes::sphere(3000, 1, 1).points, 0.01, 4, 1)));
    EXPECT_FALSE(lie(shapes::box(3000, Vector(0.6, 0.5, 0.4), 3).points));
}

TEST(LabelWithFlats, SeeksNoneWhereHardlyAnyVoteObjects)
{
    bool is_sought = false;
    const auto complete = [&]
    {
        is_sought = true;
        return FlatCompletion{};
    };
    const auto label = [](const Points&, const Vectors&, double) { return label_as(0); };
    EXPECT_FALSE(label_with_flats(samples, complete, 0.003, label));
    EXPECT_FALSE(is_sought);
    EXPECT_FALSE(label_with_flats(samples, complete, 0.03, label));
    EXPECT_TRUE(is_sought);
}

TEST(LabelWithFlats, TheyStayIfClearlyFewerVotesObjectOrFewAndNoMore)
{
    EXPECT_EQ(added_if(0.1, 0.06, 1000), 1000);
    EXPECT_EQ(added_if(0.1, 0.07, 1000), 0);
    EXPECT_EQ(added_if(0.025, 0.019, 1000), 1000);
    EXPECT_EQ(added_if(0.012, 0.012, 200), 200);
    EXPECT_EQ(added_if(0.012, 0.013, 200), 0);
}

TEST(LabelWithFlats, FewThatObjectDoNotAskForMoreSamplesThanThereAre)
{
    EXPECT_EQ(added_if(0.019, 0, 300), 300);
    EXPECT_EQ(added_if(0.019, 0, 301), 0);
    EXPECT_EQ(added_if(0.021, 0, 301), 301);
}
