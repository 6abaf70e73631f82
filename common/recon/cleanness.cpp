#include <recon/cleanness.h>

#include <recon/block_search.h>
#include <recon/delaunay.h>
#include <recon/neighbours.h>
#include <recon/parallel.h>
#include <recon/polar_balls.h>
#include <recon/sheet_stack.h>

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>

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

double quantile(std::vector<double> values, double share)
{
    if (values.empty())
        return 0;
    const auto at = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

/// Share of the places that are noisy, each weighed by the share of such around it. \pre there are places.
double measure_noisy_part(const Points& places, const std::vector<char>& noisy)
{
    constexpr int around = 8;
    const NeighbourSearch search(places);
    double sum = 0;
    for (std::size_t i = 0; i < places.size(); ++i)
    {
        if (!noisy[i])
            continue;
        std::array<int, 1 + around> near;
        std::array<double, 1 + around> squared;
        const int found = search.nearest(places[i], 1 + around, near.data(), squared.data());
        for (int k = 1; k < found; ++k) // the first is the place itself
            sum += double(noisy[std::size_t(near[std::size_t(k)])]) / around;
    }
    return sum / double(places.size());
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
    constexpr int seeds = 400, around = most_points, narrow = 12;
    const std::size_t n = samples.size();
    const std::size_t stride = std::max<std::size_t>(1, n / seeds), count = n == 0 ? 0 : (n - 1) / stride + 1;
    std::vector<char> clean(count, 0), stacked(count, 0);
    std::vector<double> flat(count, 0), whiteness(count, 0), roughness(count, 0), noise(count, 0);
    const BlockSearch search(samples);
    const auto examine = [&](std::size_t k)
    {
        const Point& centre = samples[k * stride];
        int indices[most_around_stack];
        double squared[most_around_stack];
        const int all = search.nearest(centre, most_around_stack, indices, squared);
        const int found = std::min(all, around);
        if (found < 5)
            return;
        const double radius = std::sqrt(squared[found - 1]);
        Points local;
        for (int j = 0; j < found; ++j)
            local.push_back(0.5 / radius * (samples[indices[j]] - centre));
        if (found == around)
        {
            // Of a stack of sheets those of one: the next sheet is no roughness.
            Points sheet = local;
            if (const auto own = find_stacked_sheet(samples, centre, indices, squared, all))
            {
                stacked[k] = 1;
                sheet.clear();
                for (const int j : own->members)
                    if (int(sheet.size()) < around)
                        sheet.push_back(0.5 / radius * (samples[indices[j]] - centre));
            }
            const int members = int(sheet.size());
            const double residual = measure_residual(sheet, narrow), wide = measure_residual(sheet, members);
            whiteness[k] = wide > 0 ? residual / wide : 0;
            roughness[k] = residual / std::sqrt(EIGEN_PI * sheet.back().squaredNorm() / members);
            noise[k] = 2 * radius * residual;
        }
        // Triangulations take ten times as long.
        if (k % 2 != 0)
            return;
        append_box_corners(local);
        const Triangulation delaunay = triangulate_delaunay(local);
        const Poles poles = find_poles(delaunay, local);
        const auto& cells = poles.cells.front();
        if (cells[0] == Poles::none)
            return;
        flat[k] = share_of_flat(delaunay.centres[cells[0]], &local[1], flat_count);
        clean[k] =
            cells[1] != Poles::none && has_clean_poles(delaunay.centres[cells[0]], delaunay.centres[cells[1]],
                                                       0.5 / radius * std::sqrt(squared[std::min(8, found - 1)]));
    };
    parallel_for(count, threads, {}, examine, 8);
    Cleanness result;
    Points places; // whose cells are known
    std::vector<char> noisy;
    const double cells = double((count + 1) / 2);
    for (std::size_t k = 0; k < count; k += 2)
    {
        result.long_cells += clean[k] / cells;
        result.flat_neighbours += flat[k] / cells;
        places.push_back(samples[k * stride]);
        noisy.push_back(!clean[k] && flat[k] < 0.5 && whiteness[k] > 0.5 && roughness[k] > 0.1);
        result.noisy_places += noisy.back() / cells;
    }
    if (n > places.size() * most_points)
        result.noisy_part = measure_noisy_part(places, noisy);
    result.stacked = count > 0 ? double(std::count(stacked.begin(), stacked.end(), 1)) / double(count) : 0;
    result.whiteness = quantile(whiteness, 0.25);
    result.roughness = quantile(roughness, 0.5);
    result.lower_roughness = quantile(roughness, 0.25);
    result.least_roughness = quantile(roughness, 0.1);
    result.noise = quantile(noise, 0.5);
    return result;
}

} // namespace recon
