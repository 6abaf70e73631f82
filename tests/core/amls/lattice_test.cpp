#include "filter_amls/mesh/reconstruct_amls.h"
#include "project_all.h"

#include "tests/lattices.h"
#include "tests/shapes.h"

#include <recon/noise/rounding.h>

#include <gtest/gtest.h>

using namespace recon;

namespace
{

constexpr double step = 0.05;

double distance(const Point& p)
{
    return shapes::distance_to_torus(p, 1, 0.4);
}

Points torus_on_lattice(double sigma)
{
    const Points exact = shapes::torus(40000, 1, 0.4, 4).points;
    return shapes::rounded(shapes::with_noise(exact, sigma, 5), Vector::Constant(step));
}

} // namespace

TEST(Lattice, ItsErrorIsNoise)
{
    const Points voxels = torus_on_lattice(0);
    EXPECT_LT(shapes::rms(project_all(voxels).points, distance), 0.5 * shapes::rms(voxels, distance));
    const AmlsSurfaceReport report = build_amls_surface(voxels, {}).report();
    EXPECT_NEAR(report.noise, error_of_lattice * step, 0.1 * step);
    EXPECT_NEAR(report.lattice_step, step, 1e-9);
    EXPECT_EQ(build_amls_surface(shapes::torus(40000, 1, 0.4, 4).points, {}).report().lattice_step, 0);
}

TEST(Lattice, MoreNoiseIsTold)
{
    const Points noisy = torus_on_lattice(0.8 * step);
    EXPECT_NEAR(build_amls_surface(noisy, {}).report().noise, shapes::rms(noisy, distance), 0.15 * step);
    AmlsOptions given;
    given.noise = 0.6 * step;
    EXPECT_NEAR(build_amls_surface(noisy, given).report().noise, given.noise, 1e-9);
}

TEST(Lattice, VoxelsAreNotTheSamplesOfAMesh)
{
    // Limbs of few voxels pass for thin tubes of even points.
    const auto distance_to_limb = [](const Point& p) { return shapes::distance_to_capsule(p, 0.4, 0.8); };
    const Points limb = shapes::rounded(shapes::capsule(40000, 0.4, 0.8, 4).points, Vector::Constant(0.08));
    const AmlsReconstruction mesh = reconstruct_amls(limb);
    EXPECT_EQ(mesh.genus, 0);
    EXPECT_LT(shapes::rms(mesh.mesh.vertices, distance_to_limb), 0.4 * shapes::rms(limb, distance_to_limb));
}

TEST(Lattice, ItsPlanesAreNoWalls)
{
    const AmlsReconstruction mesh = reconstruct_amls(shapes::half_torus_on_lattice());
    EXPECT_EQ(mesh.genus, 0);
    EXPECT_TRUE(mesh.warnings.empty()) << mesh.warnings.front();
}
