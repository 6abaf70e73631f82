#include "sides_of_thin_walls.h"

#include <recon/median.h>
#include <recon/mesh/crust_mesh.h>
#include <recon/mesh/mismatch.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace recon
{
namespace
{

/// Share of what was known about sides that is contradicted where walls may be mixed up: 0.014 to 0.04 on walls of 1.3
/// to 2 spacings.
constexpr double mixed_sides = 0.012;
/// Share of samples that the crust misses above which it has filled walls: 0.08 to 0.3 then, else 0.009 at most.
constexpr double missed_share = 0.01;
/// From its nearest vertex, that a sample is missed [spacings].
constexpr double missed_from = 0.5;
/// Share of points that both must turn differently, or the cells stay as they are: 0.1 to 0.5 where these mix both
/// sides; below it neither is better for certain.
constexpr double different_sides = 0.09;
/// Mean thickness below which the crust of an open cloud is wrapped around the noise of a sheet: 0.27 there, 2 and more
/// of bodies so coarse that they read as open [spacings].
constexpr double least_thickness = 0.6;
/// Noise from which on walls that it does not bury are thick, and a crust through the points is in shreds, though these
/// are so dense that a few neighbours do not show it. Both sides of a wall of two spacings have 1.4 if they read as
/// one [spacings].
constexpr double most_relative_noise = 2.5;

/// Over the points.
double median_relative_noise(const Cells& cells)
{
    std::vector<double> noise;
    for (const int c : cells.cell_of_point)
        noise.push_back(cells.scales[std::size_t(c)].sigma * std::sqrt(cells.scales[std::size_t(c)].density));
    return median(std::move(noise));
}

} // namespace

std::optional<Vectors> find_sides_of_thin_walls(const Points& points, const Cells& cells, const Vectors& cell_normals,
                                                double contradicted, bool open, CrustOfPoints& of_points, int threads,
                                                const Progress& progress)
{
    if (contradicted <= mixed_sides || median_relative_noise(cells) > most_relative_noise)
        return {};
    const CrustOfPoints::Made* made = of_points.find(points, threads, progress);
    if (!made)
        return {};
    const CrustNormals& crust = made->crust;
    const double count = double(points.size());
    int different = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
        different += crust.normals[i].dot(cell_normals[std::size_t(cells.cell_of_point[i])]) < 0;
    const auto missed = std::count_if(crust.distances.begin(), crust.distances.end(),
                                      [&](double distance) { return distance > missed_from * made->labelled.spacing; });
    if (double(missed) > missed_share * count || different <= different_sides * count)
        return {};
    if (open && (measure_thickness(crust.crust) < least_thickness * made->labelled.spacing ||
                 measure_bare_area(points, crust.crust, threads) > bare_lid))
        return {};
    return crust.normals;
}

} // namespace recon
