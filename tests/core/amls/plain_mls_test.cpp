#include "filter_amls/paper/plain_mls.h"

#include <recon/errors.h>

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace recon;

namespace
{

constexpr PlainSurface all_surfaces[] = {PlainSurface::normalised, PlainSurface::plain_n, PlainSurface::vmls,
                                         PlainSurface::pmls};

PlainMlsProjection project(const Points& queries, PlainSurface surface, int threads = 0)
{
    static const OrientedSamples samples = []
    {
        OrientedSamples s = shapes::sphere(3000, 1, 1);
        s.points = shapes::with_noise(s.points, 0.005, 2);
        return s;
    }();
    PlainMlsOptions options;
    options.surface = surface;
    options.rho_e = 0.4;
    options.threads = threads;
    return project_to_plain_mls(queries, samples, std::vector<double>(samples.points.size(), 1.0), options);
}

Points near_sphere(double offset)
{
    Points queries;
    for (const Point& p : shapes::sphere(300, 1, 3).points)
        queries.push_back(p * (1 + (queries.size() % 2 == 0 ? offset : -offset)));
    return queries;
}

} // namespace

TEST(PlainMls, AllSurfacesLieNearTheSphere)
{
    for (PlainSurface surface : all_surfaces)
    {
        const PlainMlsProjection result = project(near_sphere(0.02), surface);
        for (std::size_t i = 0; i < result.points.size(); ++i)
        {
            EXPECT_TRUE(result.converged[i]);
            // A plane-based MLS surface of width h shrinks by kappa h^2 / 2.
            EXPECT_LT(shapes::distance_to_sphere(result.points[i], 1), 0.12) << int(surface);
            EXPECT_GT(result.normals[i].dot(result.points[i].normalized()), 0.95);
        }
    }
}

TEST(PlainMls, INormalisedConvergesFromFartherThanN)
{
    const auto converged_share = [](PlainSurface surface)
    {
        const PlainMlsProjection result = project(near_sphere(0.5), surface);
        int good = 0;
        for (std::size_t i = 0; i < result.points.size(); ++i)
            good += result.converged[i] && shapes::distance_to_sphere(result.points[i], 1) < 0.12;
        return good / double(result.points.size());
    };
    EXPECT_GE(converged_share(PlainSurface::normalised), 0.99);
    EXPECT_LT(converged_share(PlainSurface::plain_n), 0.7);
}

TEST(PlainMls, IAndNHaveTheSameZeros)
{
    const PlainMlsProjection i = project(near_sphere(0.01), PlainSurface::normalised);
    const PlainMlsProjection n = project(i.points, PlainSurface::plain_n);
    for (std::size_t k = 0; k < i.points.size(); ++k)
        EXPECT_LT((n.points[k] - i.points[k]).norm(), 2e-3);
}

TEST(PlainMls, StopsWithinTheToleranceOfTheLimit)
{
    const OrientedSamples samples = shapes::sphere(3000, 1, 5);
    const std::vector<double> ones(samples.points.size(), 1.0);
    for (PlainSurface surface : {PlainSurface::normalised, PlainSurface::vmls})
    {
        PlainMlsOptions options;
        options.surface = surface;
        options.max_iterations = 300;
        const PlainMlsProjection stopped = project_to_plain_mls(near_sphere(0.3), samples, ones, options);
        const double tolerance = options.tolerance * options.rho_e / std::pow(2.0, 0.25);
        options.tolerance = 1e-12;
        const PlainMlsProjection limit = project_to_plain_mls(stopped.points, samples, ones, options);
        int within = 0;
        for (std::size_t i = 0; i < stopped.points.size(); ++i)
            within += (limit.points[i] - stopped.points[i]).norm() < tolerance;
        EXPECT_GE(within, 0.95 * double(stopped.points.size())) << int(surface);
    }
}

TEST(PlainMls, DoesNotDependOnThreads)
{
    for (PlainSurface surface : all_surfaces)
        EXPECT_EQ(project(near_sphere(0.05), surface, 1).points, project(near_sphere(0.05), surface, 3).points);
}

TEST(PlainMls, RefusesBadInput)
{
    const OrientedSamples samples = shapes::sphere(100, 1, 4);
    const std::vector<double> ones(100, 1.0);
    const auto with = [&](auto change)
    {
        PlainMlsOptions options;
        change(options);
        return project_to_plain_mls(samples.points, samples, ones, options);
    };
    EXPECT_THROW(with([](auto& o) { o.rho_e = 0; }), InvalidInput);
    EXPECT_THROW(with([](auto& o) { o.cut_off = -1; }), InvalidInput);
    EXPECT_THROW(with([](auto& o) { o.max_iterations = 0; }), InvalidInput);
    EXPECT_THROW(with([](auto& o) { o.tolerance = 0; }), InvalidInput);
    EXPECT_THROW(with([](auto& o) { o.largest_step = 0; }), InvalidInput);
    EXPECT_THROW(project_to_plain_mls(samples.points, samples, std::vector<double>(3, 1.0)), InvalidInput);
    EXPECT_THROW(project_to_plain_mls(samples.points, samples, std::vector<double>(100, 0.0)), InvalidInput);
    EXPECT_THROW(project_to_plain_mls({Point(NAN, 0, 0)}, samples, ones), InvalidInput);
    EXPECT_TRUE(project_to_plain_mls({}, samples, ones).points.empty());
    EXPECT_THROW(project_to_plain_mls(samples.points, samples, ones, {},
                                      Progress([](double, const std::string&) { return false; })),
                 Cancelled);
}
