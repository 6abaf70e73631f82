#include <recon/scan/scan_rows.h>

#include <recon/median.h>
#include <recon/scan/ray_meeting.h>
#include <recon/search/neighbours.h>

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace recon
{
namespace
{

/// Least share of the points as far from the next as that from the one after it, within a fifth: 0.97 and more of
/// frames and sweeps, 0.91 of models at most.
constexpr double even = 0.2, on_rows = 0.93;
/// How even three quarters are: within 0.025 of fifteen real sweeps, 0.05 of one, however many of the other rays saw
/// nothing or leaves; 0.14 and more from where rays of 430 models and scans meet, but of a sweep among them.
constexpr double exact = 0.03;
constexpr std::size_t most_measured = 4'000;
constexpr double least_angle = 1e-300;
/// Of so many points [count], the largest share of which half of those around in the image, itself among them, are so
/// much nearer or farther, with as much between two of them: up to 0.025 of simulated frames and sweeps, 0.44 of a room
/// from outside, but up to 0.27 of real sweeps of streets with trees.
constexpr std::size_t most_seen = 20'000;
constexpr int around = 9;
constexpr double behind = 1.1, most_hidden = 0.06;

} // namespace

bool Evenness::is_of_rows() const
{
    return share >= on_rows;
}

bool Evenness::is_exact() const
{
    return of_most <= exact;
}

double measure_deviation(const Points& points, std::size_t i, const Point& place)
{
    const double before = angle_at(place, points[i - 1], points[i]), after = angle_at(place, points[i], points[i + 1]);
    return std::abs(before - after) / std::max({before, after, least_angle});
}

Evenness measure_evenness(const Points& points, const Point& place)
{
    std::vector<double> deviations;
    for (std::size_t i = 1; i + 1 < points.size(); i += points.size() / most_measured + 1)
        deviations.push_back(measure_deviation(points, i, place));
    const auto alike = std::count_if(deviations.begin(), deviations.end(), [](double d) { return d <= even; });
    const double share = double(alike) / double(deviations.size()), of_most = quantile(deviations, 0.75);
    return {share, median(std::move(deviations)), of_most};
}

Point find_most_even(const Points& points, const Point& place)
{
    constexpr int iterations = 6;
    constexpr std::size_t most_asked = 2'000;
    constexpr double nudge = 1e-4, width = 0.1; // [distance], [relative difference]
    const std::size_t stride = points.size() / most_asked + 1;
    double range = 0;
    for (std::size_t i = 0; i < points.size(); i += stride)
        range = std::max(range, (points[i] - place).norm());
    const auto measure = [&](std::size_t i, const Point& at)
    {
        const double before = angle_at(at, points[i - 1], points[i]), after = angle_at(at, points[i], points[i + 1]);
        return (before - after) / std::max(before + after, least_angle);
    };
    Point result = place;
    for (int k = 0; k < iterations; ++k)
    {
        Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
        Vector right = Vector::Zero();
        for (std::size_t i = 1; i + 1 < points.size(); i += stride)
        {
            const double here = measure(i, result), weight = 1 / (1 + here * here / (width * width));
            Vector slope;
            for (int axis = 0; axis < 3; ++axis)
                slope[axis] = measure(i, result + nudge * range * Vector::Unit(axis)) - here;
            slope /= nudge * range;
            matrix += weight * weight * slope * slope.transpose();
            right -= weight * weight * here * slope;
        }
        const Vector step = matrix.ldlt().solve(right);
        if (!step.allFinite() || !(step.norm() < range))
            return place;
        result += step;
    }
    return result;
}

bool sees_all(const Points& points, const Point& place)
{
    Points directions;
    std::vector<double> ranges;
    for (std::size_t i = 0; i < points.size(); i += points.size() / most_seen + 1)
    {
        const Vector ray = points[i] - place;
        if (ray.isZero(0))
            continue;
        ranges.push_back(ray.norm());
        directions.push_back(ray / ranges.back());
    }
    const NeighbourSearch search(directions);
    int hidden = 0, asked = 0;
    for (std::size_t i = 0; i < directions.size(); i += directions.size() / most_measured + 1, ++asked)
    {
        int near[around];
        double squared[around];
        const int found = search.nearest(directions[i], around, near, squared);
        std::array<double, around> sorted;
        std::transform(near, near + found, sorted.begin(), [&](int k) { return ranges[std::size_t(k)]; });
        std::sort(sorted.begin(), sorted.begin() + found);
        const auto is_apart = [&](double a, double b) { return std::abs(std::log(a / b)) > std::log(behind); };
        const auto far = std::count_if(sorted.begin(), sorted.begin() + found,
                                       [&](double range) { return is_apart(range, ranges[i]); });
        // Along a floor ranges grow fast, too, but without a gap.
        const bool has_gap =
            std::adjacent_find(sorted.begin(), sorted.begin() + found, is_apart) != sorted.begin() + found;
        hidden += 2 * far >= around - 1 && has_gap;
    }
    return hidden <= most_hidden * asked;
}

} // namespace recon
