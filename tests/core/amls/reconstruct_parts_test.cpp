// Parts whose faces carry points on their rims or between round edges only.
#include "filter_amls/mesh/reconstruct_amls.h"

#include "tests/flat_shapes.h"
#include "tests/shapes.h"

#include <recon/bare_faces/bare_faces.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

using namespace recon;

TEST(ReconstructAmls, BareFlatFacesOfCleanPartsAreCompleted)
{
    const Points points = flat_shapes::coupling();
    const AmlsReconstruction found = reconstruct_amls(points);
    flat_shapes::expect_bored_coupling(found.mesh);
    EXPECT_EQ(found.samples, int(points.size()) + found.completed);
    flat_shapes::expect_bored_flange(reconstruct_amls(flat_shapes::flange()).mesh);
}

TEST(ReconstructAmls, BareFlatFacesOfNoisyPartsAreCompletedAndStayFlat)
{
    const double noise = 0.0015;
    const Points points = shapes::with_noisy_copies(flat_shapes::flange(), noise, 4, 3);
    const AmlsReconstruction found = reconstruct_amls(points);
    flat_shapes::expect_bored_flange(found.mesh);
    EXPECT_GT(found.completed, 0);
    EXPECT_GT(found.samples, found.completed);
    EXPECT_FALSE(found.surface.open);
    int in_faces = 0;
    for (const Point& p : found.mesh.vertices)
    {
        // Bores lie on the axes.
        const double beside_bores = std::min(std::abs(p.x()), std::abs(p.y()));
        const double from_rim =
            std::min(flat_shapes::outer - p.head<2>().norm(), p.head<2>().norm() - flat_shapes::hub);
        if (from_rim < 0.03 || beside_bores < 2 * flat_shapes::bore)
            continue;
        ++in_faces;
        EXPECT_LT(std::min(std::abs(p.z()), std::abs(p.z() - flat_shapes::thickness)), noise);
    }
    EXPECT_GT(in_faces, 100);
}

TEST(ReconstructAmls, BareFacesBetweenRoundedCornersAreFilled)
{
    const Points points = shapes::with_noisy_copies(flat_shapes::rounded_corners().points, 0.0005, 4, 1);
    const AmlsReconstruction found = reconstruct_amls(points);
    flat_shapes::expect_solid(found.mesh, 0, flat_shapes::rounded_volume());
    EXPECT_GT(found.completed, 0);
    EXPECT_EQ(found.warnings, std::vector<std::string>{filled_faces_text});
}

TEST(ReconstructAmls, BoresOfANoisyPlateStayThoughFewVotesObject)
{
    const Points points = shapes::with_noisy_copies(flat_shapes::bored_plate(80), 0.003, 1, 1);
    const AmlsReconstruction found = reconstruct_amls(points);
    EXPECT_EQ(found.genus, flat_shapes::plate_bores);
    EXPECT_EQ(found.components, 1);
}
