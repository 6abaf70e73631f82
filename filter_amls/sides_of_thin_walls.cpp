#include "sides_of_thin_walls.h"

#include "crust_normals.h"
#include "label_points.h"

#include <recon/cleanness.h>
#include <recon/crust_mesh.h>
#include <recon/errors.h>
#include <recon/labelled_balls.h>
#include <recon/mismatch.h>
#include <recon/parallel.h>

namespace recon
{
namespace
{

/// Share of what was known about sides that is contradicted where walls may be mixed up: 0.014 to 0.04 on walls of 1.3
/// to 2 spacings.
constexpr double mixed_sides = 0.012;
/// Cleanness::least_roughness above which, and Cleanness::flat_neighbours below which the crust is in shreds: thin
/// walls have up to 0.33 and at least 0.5 with noise of 0.3 spacings; 0.34 to 0.4 with 0.7, and 0.37 to 0.5 in clouds
/// of noisy copies.
constexpr double much_noise = 0.34, few_flat = 0.5;
/// Share of violated votes above which the crust is not trusted; it is wrong from 0.055 on, mostly.
constexpr double bearable_votes = 0.06;
/// Share of samples that the crust misses above which it has filled walls: 0.08 to 0.3 then, else 0.009 at most.
constexpr double missed_share = 0.01;
/// Share of points that both must turn differently, or the cells stay as they are: 0.1 to 0.5 where these mix both
/// sides; below it neither is better for certain.
constexpr double different_sides = 0.09;
/// Mean thickness below which the crust of an open cloud is wrapped around the noise of a sheet: 0.27 there, 2 and more
/// of bodies so coarse that they read as open [spacings].
constexpr double least_thickness = 0.6;

} // namespace

std::optional<Vectors> find_sides_of_thin_walls(const Points& points, const Vectors& cell_normals,
                                                const std::vector<int>& cell_of_point, double contradicted, bool open,
                                                int threads, const Progress& progress)
{
    if (contradicted <= mixed_sides)
        return {};
    const Cleanness cleanness = measure_cleanness(points, threads);
    if (cleanness.least_roughness > much_noise || cleanness.flat_neighbours < few_flat)
        return {};
    PhaseTimes times;
    const LabelledBalls labelled =
        label_polar_balls(points, {}, options_for_labels(threads), times, progress.part(0, 0.8));
    if (labelled.violated_votes > bearable_votes)
        return {};
    CrustNormals crust;
    try
    {
        crust = list_crust_normals(points, labelled, threads, progress.part(0.8, 1));
    }
    catch (const AlgorithmFailure&) // nothing is inside
    {
        return {};
    }
    const double count = double(points.size());
    int different = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
        different += crust.normals[i].dot(cell_normals[std::size_t(cell_of_point[i])]) < 0;
    if (crust.missed > missed_share * count || different <= different_sides * count)
        return {};
    if (open && (measure_thickness(crust.crust) < least_thickness * labelled.spacing ||
                 measure_bare_area(points, crust.crust, threads) > bare_lid))
        return {};
    return std::move(crust.normals);
}

} // namespace recon
