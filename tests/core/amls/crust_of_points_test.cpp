#include "filter_amls/mesh/label_points.h"
#include "filter_amls/sides/crust_of_points.h"
#include "filter_amls/sides/sides_of_thin_walls.h"
#include "filter_amls/surface/surface_data.h"

#include <recon/errors.h>
#include <recon/search/spatial_order.h>

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

using namespace recon;

namespace
{

/// Small discs anywhere in a cube.
Points leaves(int count, int points_each)
{
    const Points centres = shapes::scattered(count, {1, 1, 1}, 5);
    const Points axes = shapes::scattered(2 * count, {1, 1, 1}, 6);
    const Points within = shapes::scattered(count * points_each, {1, 1, 1}, 7);
    Points result;
    for (std::size_t i = 0; i < within.size(); ++i)
    {
        const std::size_t leaf = i / std::size_t(points_each);
        const Vector &u = axes[2 * leaf], &v = axes[2 * leaf + 1];
        result.push_back(centres[leaf] + 0.1 * (within[i].x() * u.normalized() + within[i].y() * v.normalized()));
    }
    return result;
}

Points in_unit_frame(const Points& points)
{
    return UnitFrame(points).to_unit(points_at(order_input(points).order, points));
}

} // namespace

TEST(CrustOfPoints, SurfacesOfTheSamePointsShareIt)
{
    const Points tube = shapes::thin_tube(3).points;
    const AmlsSurface first = build_amls_surface(tube);
    ASSERT_TRUE(first.data().crust->made());
    AmlsOptions less_noise;
    less_noise.noise = first.report().noise / 2;
    EXPECT_EQ(build_amls_surface(tube, less_noise, {}, {}, &first).data().crust, first.data().crust);
    EXPECT_NE(build_amls_surface(shapes::thin_tube(4).points, {}, {}, {}, &first).data().crust, first.data().crust);
}

TEST(CrustOfPoints, LabelsOfExactPointsAreThoseThatItWasMadeOf)
{
    const Points tube = shapes::thin_tube(3).points;
    const AmlsSurface surface = build_amls_surface(tube);
    ASSERT_TRUE(surface.data().crust->made());
    PhaseTimes times;
    const auto label = [&] { return label_points(tube, surface, true, options_for_labels(1), times, {}); };
    const LabelledSamples found = label();
    *surface.data().crust = {};
    const LabelledSamples anew = label();
    ASSERT_TRUE(found.is_exact && anew.is_exact);
    EXPECT_EQ(found.labelled.labels, anew.labelled.labels);
    EXPECT_EQ(found.labelled.violated_votes, anew.labelled.violated_votes);
    EXPECT_EQ(found.samples, anew.samples);
}

TEST(CrustOfPoints, IsNotAskedForTheSidesOfNoiseOfSpacings)
{
    const OrientedSamples sphere = shapes::sphere(2000, 1, 3);
    Cells cells;
    cells.cell_of_point.resize(sphere.points.size());
    std::iota(cells.cell_of_point.begin(), cells.cell_of_point.end(), 0);
    const auto ask = [&](double spacings)
    {
        constexpr double density = 100;
        cells.scales.assign(sphere.points.size(), {spacings / std::sqrt(density), density, 1});
        CrustOfPoints crust;
        find_sides_of_thin_walls(UnitFrame(sphere.points).to_unit(sphere.points), cells, sphere.normals, 1, false,
                                 crust, 1);
        return crust.made() != nullptr;
    };
    EXPECT_TRUE(ask(1));
    EXPECT_FALSE(ask(4));
}

TEST(CrustOfPoints, NoisyPointsHaveNone)
{
    const Points torus = in_unit_frame(shapes::with_noise(shapes::torus(4000, 1, 0.3, 3).points, 0.1, 5));
    EXPECT_FALSE(CrustOfPoints().find(torus, 1));
}

TEST(CrustOfPoints, ACrustThatContradictsThePointsIsNoneAndIsNotMadeAgain)
{
    const Points foliage = in_unit_frame(leaves(150, 40));
    CrustOfPoints crust;
    EXPECT_FALSE(crust.find(foliage, 1));
    const Progress refused([](double, const std::string&) { return false; });
    EXPECT_NO_THROW(crust.find(foliage, 1, refused));
    EXPECT_THROW(CrustOfPoints().find(foliage, 1, refused), Cancelled) << "flat enough to be tried";
}
