#include <recon/noise/cleanness.h>

#include <recon/median.h>
#include <recon/noise/noisy_fibres.h>
#include <recon/noise/noisy_lines.h>
#include <recon/noise/sheet_stack.h>
#include <recon/noise/stray_samples.h>
#include <recon/parallel.h>
#include <recon/search/block_search.h>
#include <recon/triangulation/delaunay.h>
#include <recon/triangulation/polar_balls.h>

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

namespace recon
{
namespace
{

constexpr int most_points = 32;
constexpr int flat_count = 3; // neighbours asked whether they lie flat

/// Root mean square of the points' distances to their least-squares quadric, a height field over their principal plane.
double measure_residual(const Points& points, int count)
{
    constexpr int unknowns = 6;
    Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, most_points> offsets(3, count);
    for (int i = 0; i < count; ++i)
        offsets.col(i) = points[i];
    offsets.colwise() -= Point(offsets.rowwise().mean());
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(offsets * offsets.transpose());
    const auto frame = axes.eigenvectors();
    Eigen::Matrix<double, Eigen::Dynamic, unknowns, 0, most_points, unknowns> terms(count, unknowns);
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most_points, 1> heights(count);
    for (int i = 0; i < count; ++i)
    {
        const Vector p = frame.transpose() * offsets.col(i);
        heights[i] = p[0];
        terms.row(i) << 1, p[1], p[2], p[1] * p[1], p[1] * p[2], p[2] * p[2];
    }
    const Eigen::Matrix<double, unknowns, 1> quadric = terms.colPivHouseholderQr().solve(heights);
    return std::sqrt((heights - terms * quadric).squaredNorm() / (count - unknowns));
}

/// What one sample and its nearest tell.
struct Place
{
    bool is_clean = false, is_stacked = false;
    double flat = 0, whiteness = 0, roughness = 0, noise = 0, spacing = 0;

    bool is_uneven() const { return !is_clean && flat < 0.5 && roughness > 0.1; }
    bool is_noisy() const { return is_uneven() && whiteness > 0.5; }
};

/// \param with_cells or else `is_clean` and `flat` stay 0: a triangulation takes ten times as long as all else.
Place examine_place(const Points& samples, const BlockSearch& search, const Point& centre, bool with_cells)
{
    constexpr int narrow = 12;
    Place result;
    int indices[most_around_stack];
    double squared[most_around_stack];
    const int all = search.nearest(centre, most_around_stack, indices, squared);
    const int found = std::min(all, most_points);
    if (found < 5)
        return result;
    const double radius = std::sqrt(squared[found - 1]);
    Points local;
    for (int j = 0; j < found; ++j)
        local.push_back(0.5 / radius * (samples[indices[j]] - centre));
    if (found == most_points)
    {
        // Of a stack of sheets those of one: the next sheet is no roughness.
        Points sheet = local;
        if (const auto own = find_stacked_sheet(samples, centre, indices, squared, all))
        {
            result.is_stacked = true;
            sheet.clear();
            for (const int j : own->members)
                if (int(sheet.size()) < most_points)
                    sheet.push_back(0.5 / radius * (samples[indices[j]] - centre));
        }
        const int members = int(sheet.size());
        const double residual = measure_residual(sheet, narrow), wide = measure_residual(sheet, members);
        result.whiteness = wide > 0 ? residual / wide : 0;
        const double spacing = std::sqrt(EIGEN_PI * sheet.back().squaredNorm() / members);
        result.roughness = residual / spacing;
        result.noise = 2 * radius * residual;
        result.spacing = 2 * radius * spacing;
    }
    if (!with_cells)
        return result;
    append_box_corners(local);
    const Triangulation delaunay = triangulate_delaunay(local);
    const Poles poles = find_poles(delaunay, local);
    const auto& cells = poles.cells.front();
    if (cells[0] == Poles::none)
        return result;
    result.flat = share_of_flat(delaunay.centres[cells[0]], &local[1], flat_count);
    result.is_clean =
        cells[1] != Poles::none && has_clean_poles(delaunay.centres[cells[0]], delaunay.centres[cells[1]],
                                                   0.5 / radius * std::sqrt(squared[std::min(8, found - 1)]));
    return result;
}

/// Share of noisy ones among the places of a sample's surroundings.
double measure_noise_around(const Points& samples, const BlockSearch& search, const Point& centre)
{
    constexpr int around = 256, asked = 8;
    std::array<int, 1 + around> indices;
    std::array<double, 1 + around> squared;
    const int found = search.nearest(centre, 1 + around, indices.data(), squared.data());
    int noisy = 0;
    for (int k = 1; k <= asked; ++k)
    {
        const int at = indices[std::size_t(k * (found - 1) / asked)];
        noisy += examine_place(samples, search, samples[std::size_t(at)], true).is_noisy();
    }
    return double(noisy) / asked;
}

} // namespace

bool has_clean_poles(const Vector& first, const Vector& second, double eighth)
{
    return -first.dot(second) > 0.8 * first.norm() * second.norm() &&
           std::min(first.norm(), second.norm()) > 0.4 * eighth;
}

double share_of_flat(const Vector& first, const Point* neighbours, int count)
{
    int flat = 0;
    for (int i = 0; i < count; ++i)
        flat += neighbours[i].dot(first) > -0.3 * neighbours[i].norm() * first.norm();
    return count > 0 ? double(flat) / count : 1;
}

double measure_flat_neighbours(const Points& samples, const BlockSearch& search, const Point& sample)
{
    std::array<int, most_points> indices;
    std::array<double, most_points> squared;
    const int found = search.nearest(sample, most_points, indices.data(), squared.data());
    const double radius = std::sqrt(squared[std::size_t(found - 1)]);
    Points local;
    for (int j = 0; j < found; ++j)
        local.push_back(0.5 / radius * (samples[std::size_t(indices[std::size_t(j)])] - sample));
    append_box_corners(local);
    const Triangulation delaunay = triangulate_delaunay(local);
    const Poles poles = find_poles(delaunay, local);
    const int first = poles.cells.front()[0];
    return first == Poles::none ? 1 : share_of_flat(delaunay.centres[first], &local[1], flat_count);
}

Cleanness measure_cleanness(const Points& samples, int threads)
{
    if (samples.empty())
        return {};
    constexpr int seeds = 400;
    const std::size_t n = samples.size();
    const std::size_t stride = std::max<std::size_t>(1, n / seeds), count = (n - 1) / stride + 1;
    const BlockSearch search(samples, threads);
    std::vector<Place> places(count);
    const auto examine = [&](std::size_t k)
    { places[k] = examine_place(samples, search, samples[k * stride], k % 2 == 0); };
    parallel_for(count, threads, {}, examine, 8);
    Cleanness result;
    result.has_noisy_lines = has_noisy_lines(samples, search, threads) || has_noisy_fibres(samples, search, threads);
    std::vector<double> whiteness, uneven_whiteness, roughness, noise, spacing;
    std::vector<std::size_t> noisy;
    const double cells = double((count + 1) / 2); // are known of every second place
    for (std::size_t k = 0; k < count; ++k)
    {
        const Place& place = places[k];
        result.stacked += place.is_stacked / double(count);
        whiteness.push_back(place.whiteness);
        roughness.push_back(place.roughness);
        noise.push_back(place.noise);
        spacing.push_back(place.spacing);
        if (k % 2 != 0)
            continue;
        result.long_cells += place.is_clean / cells;
        result.flat_neighbours += place.flat / cells;
        if (place.is_uneven())
        {
            uneven_whiteness.push_back(place.whiteness);
            result.white_places += (place.whiteness > 0.7) / cells;
        }
        if (place.is_noisy())
            noisy.push_back(k);
    }
    result.noisy_places = double(noisy.size()) / cells;
    if (double(n) > cells * most_points && result.noisy_places <= Cleanness::many_noisy)
    {
        std::vector<double> parts(noisy.size());
        const auto look_around = [&](std::size_t i)
        { parts[i] = measure_noise_around(samples, search, samples[noisy[i] * stride]); };
        parallel_for(noisy.size(), threads, {}, look_around, 1);
        result.noisy_part = std::accumulate(parts.begin(), parts.end(), 0.0) / cells;
    }
    result.uneven_whiteness = quantile(std::move(uneven_whiteness), 0.5);
    result.whiteness = quantile(std::move(whiteness), 0.25);
    result.roughness = quantile(roughness, 0.5);
    result.lower_roughness = quantile(roughness, 0.25);
    result.least_roughness = quantile(std::move(roughness), 0.1);
    result.noise = quantile(std::move(noise), 0.5);
    result.spacing = quantile(std::move(spacing), 0.5);
    if (n < Cleanness::fewest_for_mixed)
        result.uneven_whiteness = 0;
    else if (result.is_clean() && !result.is_noisy_in_parts() && result.stacked < Cleanness::few_stacked)
        result.strays = measure_strays(samples, search, threads);
    return result;
}

} // namespace recon
