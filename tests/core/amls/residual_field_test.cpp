#include "filter_amls/surface/residual_field.h"

#include "filter_amls/surface/project.h"
#include "filter_amls/surface/surface_data.h"

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace recon;

namespace
{

/// Root mean square distance from the torus.
double rms(const Points& points, const UnitFrame* frame = nullptr)
{
    double squares = 0;
    for (const Point& p : points)
        squares += std::pow(shapes::distance_to_torus(frame ? frame->from_unit(p) : p, 1, 0.4), 2);
    return std::sqrt(squares / double(points.size()));
}

/// The samples on the surface as it is before residuals are asked, in the unit frame.
AmlsProjection project_samples(const AmlsSurface& surface)
{
    const AmlsSurface::Data& data = surface.data();
    return project_in_frame(data, data.points, data.cells.cell_of_point, {}, 1);
}

/// Of projected samples corrected by their residuals.
double rms_after_correction(const AmlsSurface& surface, AmlsProjection projected)
{
    AmlsSurface::Data data(surface.data().frame);
    data.points = surface.data().points;
    data.cells = surface.data().cells;
    const ResidualField field = measure_residuals(data, projected, TrialPlaces(data, projected, 1), 0.4, 1);
    if (!field.empty())
        correct_by_residuals(data, field, data.cells.cell_of_point, projected, 1);
    return rms(projected.points, &data.frame);
}

} // namespace

TEST(ResidualField, FewGoodSamplesDecide)
{
    // One sample in five is exact, and dense for the noise of the others.
    const Points noisy = shapes::with_noisy_copies(shapes::torus(8000, 1, 0.4, 1).points, 0.04, 4, 2);
    const AmlsSurface surface = build_amls_surface(noisy);
    ASSERT_FALSE(surface.data().residuals.empty());
    const double before = rms(project_samples(surface).points, &surface.data().frame);
    EXPECT_LT(rms(project_to_amls(noisy, surface).points), 0.85 * before);
}

TEST(ResidualField, APassAfterTheOtherTellsMoreThanOne)
{
    const Points noisy =
        shapes::with_noisy_copies(shapes::ellipsoid(12000, Vector(1, 0.7, 0.4), 9).points, 0.03, 4, 10);
    const AmlsSurface surface = build_amls_surface(noisy);
    const AmlsSurface::Data& data = surface.data();
    ASSERT_EQ(data.residuals.size(), 2u);
    // Each field lists what is left: that of the second lies nearer to the truth, and so do the points in the end.
    const auto rms_to_exact = [&](const Points& points)
    {
        double squares = 0;
        int exact = 0;
        for (std::size_t i = 0; i < data.points.size(); ++i)
        {
            const Point p = data.frame.from_unit(data.points[i]).cwiseQuotient(Vector(1, 0.7, 0.4));
            if (std::abs(p.norm() - 1) > 1e-6)
                continue;
            squares += (points[i] - data.points[i]).squaredNorm();
            ++exact;
        }
        EXPECT_GT(exact, 11000);
        return std::sqrt(squares / exact);
    };
    AmlsProjection projected = project_samples(surface);
    const double none = rms_to_exact(projected.points);
    correct_by_residuals(data, data.residuals[0], data.cells.cell_of_point, projected, 1);
    const double one = rms_to_exact(projected.points), both = rms_to_exact(data.projected.points);
    EXPECT_LT(one, 0.9 * none);
    EXPECT_LT(both, 0.995 * one);
    // What is at hand is what is computed when others are asked in the same places.
    correct_by_residuals(data, data.residuals[1], data.cells.cell_of_point, projected, 1);
    EXPECT_EQ(projected.points, data.projected.points);
}

TEST(ResidualField, DependsNeitherOnThreadsNorOnTheOrder)
{
    Points noisy = shapes::with_noisy_copies(shapes::torus(3000, 1, 0.4, 7).points, 0.05, 4, 8);
    const auto project = [&](int threads)
    {
        AmlsOptions options;
        options.threads = threads;
        AmlsProjectionOptions projection;
        projection.threads = threads;
        const AmlsSurface surface = build_amls_surface(noisy, options);
        EXPECT_FALSE(surface.data().residuals.empty());
        return project_to_amls(noisy, surface, projection).points;
    };
    Points forward = project(1);
    EXPECT_EQ(forward, project(3));
    std::reverse(noisy.begin(), noisy.end());
    std::reverse(forward.begin(), forward.end());
    EXPECT_EQ(forward, project(2));
}

TEST(ResidualField, NoiseAloneIsNotFollowed)
{
    for (const double sigma : {0.01, 0.04})
    {
        const Points noisy = shapes::with_noise(shapes::torus(30000, 1, 0.4, 3).points, sigma, 4);
        const AmlsSurface surface = build_amls_surface(noisy);
        const AmlsProjection projected = project_samples(surface);
        EXPECT_LT(rms_after_correction(surface, projected), 1.1 * rms(projected.points, &surface.data().frame))
            << sigma;
    }
}

TEST(ResidualField, NoiseIsNotFollowedBesideExactSamples)
{
    // What the exact half agrees on says nothing of the noisy one.
    double before = 0, after = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed)
    {
        const Points exact = shapes::torus(20000, 1, 0.4, seed).points;
        const AmlsSurface surface = build_amls_surface(shapes::with_noise_beyond(0, exact, 0.02, seed + 10));
        const UnitFrame& frame = surface.data().frame;
        const auto rms_where_noisy = [&](const Points& moved)
        {
            Points noisy;
            for (const Point& p : moved)
                if (frame.from_unit(p).x() > 0.1)
                    noisy.push_back(p);
            return rms(noisy, &frame);
        };
        ASSERT_FALSE(surface.data().residuals.empty());
        before += rms_where_noisy(project_samples(surface).points);
        after += rms_where_noisy(surface.data().projected.points);
    }
    EXPECT_LT(after, 1.1 * before);
}

TEST(ResidualField, AnErrorOfTheSurfaceIsFound)
{
    // What an error does to residuals, here made by moving the projected samples outward.
    const Points noisy = shapes::with_noisy_copies(shapes::torus(8000, 1, 0.4, 5).points, 0.04, 4, 6);
    const AmlsSurface surface = build_amls_surface(noisy);
    AmlsProjection projected = project_samples(surface);
    const double error = 0.3 * 0.04 / surface.data().frame.scale();
    for (std::size_t i = 0; i < projected.points.size(); ++i)
        projected.points[i] += error * projected.normals[i];
    EXPECT_LT(rms_after_correction(surface, projected), 0.5 * rms(projected.points, &surface.data().frame));
}
