#include "filter_amls/cells/cells_across.h"
#include "filter_amls/surface/project.h"

#include "tests/medial_shapes.h"
#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

using namespace recon;

namespace
{

constexpr double width = 0.1;

/// Noisy points of horizontal sheets, cells that know the sheets' normals, and one that does not.
struct Scene
{
    explicit Scene(double noise = 0.25 * width) : sigma(noise) {}

    void add_sheet(double height, double side, double end = 0.5)
    {
        const std::uint64_t seed = points.size(); // other samples for each sheet
        Points sheet = shapes::scattered(4000, Vector(1, 1, 0), seed);
        sheet.erase(std::remove_if(sheet.begin(), sheet.end(), [&](const Point& p) { return p.x() >= end; }),
                    sheet.end());
        for (const Point& p : shapes::with_noise(sheet, sigma, seed + 1))
            points.push_back(p + height * Vector::UnitZ());
        for (double x = -0.5; x < end; x += 0.6 * width)
            for (double y = -0.5; y < 0.5; y += 0.6 * width)
                add_cell({x, y, height}, {0, 0, side}, 1);
    }
    void add_cell(const Point& mean, const Vector& normal, double mass)
    {
        cells.means.push_back(mean);
        cells.counts.push_back(1);
        cells.scales.push_back({sigma, 4000, width});
        normals.normals.push_back(normal);
        normals.feet.push_back(mean);
        normals.mass.push_back(mass);
        normals.company.push_back(mass);
        normals.kinds.push_back(CellKind::regular);
        normals.widening.push_back(1);
    }
    /// Normal that a cell which stands across gets.
    Vector settle(const Point& mean, double mass = 0.3)
    {
        add_cell(mean, Vector::UnitX(), mass);
        const Vectors found =
            turn_cells_across(points, BlockSearch(points), cells, BlockSearch(cells.means), normals, 1);
        for (std::size_t c = 0; c + 1 < found.size(); ++c)
            EXPECT_EQ(found[c], normals.normals[c]);
        EXPECT_EQ(found, turn_cells_across(points, BlockSearch(points), cells, BlockSearch(cells.means), normals, 3));
        return found.back();
    }

    double sigma;
    Points points;
    Cells cells;
    CellNormals normals;
};

} // namespace

TEST(CellsAcross, OfTheTailsOfTheNoiseTakeTheNormalsAround)
{
    for (const double side : {1, -1})
    {
        Scene scene;
        scene.add_sheet(0, side);
        EXPECT_GT(side * scene.settle({0.03, 0.03, 3 * scene.sigma}).z(), 0.99);
    }
}

TEST(CellsAcross, OfARimOrBetweenSheetsStay)
{
    Scene rim;
    rim.add_sheet(0, 1, 0.03);
    EXPECT_EQ(rim.settle({0.03, 0.03, 0}), Vector::UnitX());

    Scene plate;
    plate.add_sheet(2 * plate.sigma, 1);
    plate.add_sheet(-2 * plate.sigma, -1);
    EXPECT_EQ(plate.settle({0.03, 0.03, 0}), Vector::UnitX());
}

TEST(CellsAcross, StayWhereNoiseDoesNotExplainThem)
{
    Scene dense;
    dense.add_sheet(0, 1);
    EXPECT_EQ(dense.settle({0.03, 0.03, dense.sigma}, 1), Vector::UnitX());

    Scene thin(0.1 * width);
    thin.add_sheet(0, 1);
    EXPECT_EQ(thin.settle({0.03, 0.03, 3 * thin.sigma}), Vector::UnitX());
}

TEST(CellsAcross, SamplesOfACrustLieOnTheFacesOfABox)
{
    // Twelve stayed in the tails of the noise before.
    const shapes::MedialShape box = shapes::medial_box(20000, 912);
    const double sigma = 0.5 * box.spacing;
    const Points cloud = box.noisy(0.5, true, 917);
    AmlsProjectionOptions options;
    options.sharp = false;
    const AmlsProjection projected = project_to_amls(cloud, build_amls_surface(cloud, {}), options);
    int off = 0;
    for (const Point& p : projected.points)
    {
        std::array<double, 3> depths = {2 - std::abs(p.x()), 1.5 - std::abs(p.y()), 1 - std::abs(p.z())};
        std::sort(depths.begin(), depths.end());
        off += depths[1] > 6 * sigma && std::abs(depths[0]) > 1.5 * sigma; // edges are rounded
    }
    EXPECT_LE(off, 2);
}
