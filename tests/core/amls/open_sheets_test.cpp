#include "filter_amls/mesh/open_sheets.h"

#include "tests/shapes.h"

#include <gtest/gtest.h>

using namespace recon;

// The backs of either side come through the other one, and reach all samples.
TEST(BackOpenSheet, WallsOfAFilledPipeAreNoSheet)
{
    const shapes::Pipe pipe = shapes::pipe(1.3, 0, 3);
    const Points samples = UnitFrame(pipe.samples.points).to_unit(pipe.samples.points);
    Vectors turned = pipe.samples.normals;
    for (std::size_t i = 0; i < turned.size(); ++i)
        if (turned[i].dot(pipe.samples.points[i]) < 0)
            turned[i] = -turned[i];
    PhaseTimes times;
    const LabelledBalls filled = label_polar_balls(samples, turned, {}, times);
    ASSERT_GT(filled.violated_votes, 0.1);
    EXPECT_FALSE(back_open_sheet(samples, pipe.samples.normals, filled, false, {}, times));
    // What was seen from known places has no other side, whatever the votes say.
    EXPECT_TRUE(back_open_sheet(samples, pipe.samples.normals, filled, true, {}, times));
}
