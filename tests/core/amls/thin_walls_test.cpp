#include <filter_amls/project.h>

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace recon;

TEST(ProjectToAmls, LeavesBothSidesOfAThinPlateWhereTheyAre)
{
    // One sample a unit of area, noise of a tenth of the wall's thickness or more.
    const Vector sides(50, 50, 2);
    for (const double noise : {0.2, 0.3})
    {
        const Points plate = shapes::with_noise(shapes::box(5400, sides, 1).points, noise, 2);
        const AmlsSurface surface = build_amls_surface(plate);
        const AmlsProjection projected = project_to_amls(plate, surface);
        double before = 0, after = 0;
        int on_faces = 0, outward = 0;
        for (std::size_t i = 0; i < plate.size(); ++i)
        {
            before += std::pow(shapes::distance_to_box(plate[i], sides), 2);
            after += std::pow(shapes::distance_to_box(projected.points[i], sides), 2);
            if (plate[i].head<2>().cwiseAbs().maxCoeff() > 24)
                continue;
            ++on_faces;
            outward += projected.normals[i].z() * plate[i].z() > 0;
        }
        EXPECT_LT(std::sqrt(after / before), 0.85) << noise;
        EXPECT_GT(outward, 0.97 * on_faces) << noise;
    }
}
