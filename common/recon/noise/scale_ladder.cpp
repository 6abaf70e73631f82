#include <recon/noise/scale_ladder.h>

#include <recon/noise/noisy_fibres.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace recon
{
namespace
{

constexpr double pi = 3.14159265358979323846;
constexpr int smallest_count = 3 * patch_coefficients;
constexpr int many = 150; // neighbours; beyond it a subsample does
constexpr double growth = 1.5;
/// A residual that grows more than this from one scale to the next is not noise but shape: a thin part, a crease.
constexpr double settled = 1.2;
/// Noise above which it may be a stack of sheets [spacings].
constexpr double thick = 0.3;
/// Noise above which exact samples among noisy copies look like a sheet of a stack [spacings].
constexpr double very_thick = 3;

/// As how many points a fibre counts, at most: where noise is less than the distance to the next, few, since windows
/// must reach several; from half of that on as many. By the noise in these distances between both.
constexpr double fewest_of_fibre = 1.5, most_of_fibre = 5, of_fibre_by_noise = 10;
/// Of noisy lines [radii that reach over several].
constexpr double line_distance = 0.9;

/// What a Gaussian slab shows inside a ball of radius R around its middle: at height z the ball cuts a disc of area
/// pi (R^2 - z^2), so that the variance falls to (1 - 3 t) / (1 - t) and the count to 1 - t, t = sigma^2 / R^2.
LocalNoise correct_for_ball(double residual, int count, double radius)
{
    const double squared = std::max(radius * radius, 1e-300);
    double t = 0;
    for (int i = 0; i < 8; ++i)
        t = std::min(1.0 / 9, residual * residual / squared * (1 - t) / (1 - 3 * t));
    return {std::sqrt(t) * radius, count / (pi * squared * (1 - t))};
}

} // namespace

CloudPyramid::CloudPyramid(Points points, int threads)
{
    levels.push_back(std::move(points));
    while (levels.back().size() > step * coarsest && levels.size() < 6)
    {
        const Points& finer = levels.back();
        Points coarser;
        for (std::size_t i = step / 2; i < finer.size(); i += step)
            coarser.push_back(finer[i]);
        levels.push_back(std::move(coarser));
    }
    for (const Points& level : levels)
        searches.emplace_back(level, threads);
}

ScaleLadder::ScaleLadder(const CloudPyramid& pyramid, int most) : pyramid_(pyramid)
{
    const int all = int(pyramid.levels[0].size());
    // Of a small cloud take a part, or the quadric would have to follow the whole shape.
    limit_ = std::min({all, most, std::max(all / 3, smallest_count)});
    neighbours_.resize(std::size_t(std::max(limit_, most_around_stack)));
    squared_.resize(neighbours_.size());
}

LocalNoise ScaleLadder::estimate(const Point& seed, bool ask_for_stack)
{
    LocalNoise result = climb(seed);
    if (ask_for_stack && (!result.settled || result.sigma * std::sqrt(result.density) > thick))
    {
        result.stacked = find_sheet(seed);
        if (result.stacked && result.sigma * std::sqrt(result.density) > very_thick &&
            !has_sheets_beside(*result.stacked))
            result.stacked.reset();
    }
    return result;
}

LocalNoise ScaleLadder::estimate_over_fibres(const Point& seed, double reach)
{
    LocalNoise result = climb(seed, reach);
    const double fibres = fibres_in_reach / (pi * reach * reach);
    const double told =
        std::clamp(of_fibre_by_noise * result.sigma * std::sqrt(fibres), fewest_of_fibre, most_of_fibre);
    result.density = std::min(result.density, told * fibres);
    return result;
}

LocalNoise ScaleLadder::estimate_across_lines(const Point& seed, double reach)
{
    LocalNoise result = climb(seed, reach);
    const double apart = line_distance * reach;
    result.density = std::min(result.density, 1 / (apart * apart));
    return result;
}

LocalNoise ScaleLadder::climb(const Point& seed, double least)
{
    double k = smallest_count;
    found_ = 0;
    while (true)
    {
        // Few do where there is little noise.
        measure(seed, k, k < 2 * smallest_count ? k * growth : k * growth * growth * growth);
        if (radius_ >= std::max(patch_flatness * fit_.height, least) || k * growth > limit_)
            break;
        k *= growth;
    }
    // Around the foot from now on, where the correction for the ball holds.
    const Point foot = fit_.foot;
    measure(foot, k, k * growth);
    const LocalNoise narrow = correct_for_ball(fit_.distance, count_, radius_);
    const double narrow_radius = radius_;
    if (k * growth > limit_)
        return {narrow.sigma, narrow.density, false};
    measure(foot, k * growth, k * growth);
    const LocalNoise wide = correct_for_ball(fit_.distance, count_, radius_);
    // What a quadric cannot follow grows with the third power of the radius: the two scales tell it from the noise.
    // Only upwards: of a few clusters of points a quadric leaves too little at first.
    const double ratio = std::pow(radius_ / std::max(narrow_radius, 1e-300), 6);
    const double a = narrow.sigma * narrow.sigma, b = wide.sigma * wide.sigma;
    const double variance = ratio > 1.5 ? std::max(a, (ratio * a - b) / (ratio - 1)) : a;
    // A thin part is as flat as a thick layer of noise, but its residuals keep to both faces.
    const double n = count_ / share_, doubt = std::max(0.5, 1.2 * std::sqrt(24 / n));
    const bool gaussian = fit_.kurtosis >= 3 * (n - 1) / (n + 1) - doubt;
    return {std::sqrt(variance), wide.density, gaussian && wide.sigma <= settled * narrow.sigma,
            fit_two_sheets(residuals_, radius_)};
}

std::optional<StackedSheet> ScaleLadder::find_sheet(const Point& at)
{
    const int found = pyramid_.searches[0].nearest(at, most_around_stack, neighbours_.data(), squared_.data());
    return find_stacked_sheet(pyramid_.levels[0], at, neighbours_.data(), squared_.data(), found);
}

bool ScaleLadder::has_sheets_beside(const StackedSheet& sheet)
{
    constexpr std::size_t asked = 4;
    const int reach = std::min(most_around_stack, int(pyramid_.levels[0].size()));
    std::vector<int> beside;
    auto member = sheet.members.begin();
    for (int i = 0; beside.size() < asked && i < reach; ++i)
        if (member != sheet.members.end() && *member == i)
            ++member;
        else
            beside.push_back(neighbours_[i]);
    return std::any_of(beside.begin(), beside.end(),
                       [&](int i) { return find_sheet(pyramid_.levels[0][i]).has_value(); });
}

ScaleLadder::Wanted ScaleLadder::wanted(double k) const
{
    Wanted w{0, 1, 0};
    for (double c = k; c > many && w.level + 1 < pyramid_.levels.size();
         c /= CloudPyramid::step, w.share *= CloudPyramid::step)
        ++w.level;
    w.count = std::max(1, std::min(int(k), limit_) / w.share);
    return w;
}

void ScaleLadder::find_neighbours(const Point& centre, double k, double largest)
{
    const Wanted now = wanted(k), later = wanted(largest);
    if (found_ >= now.count && level_ == now.level && centre_ == centre)
        return;
    const int count = later.level == now.level ? later.count : now.count;
    if (reach_ > 0) // of the search before, among neighbours of another number
        reach_ *= std::sqrt(double(count * now.share) / reach_count_);
    reach_count_ = count * now.share;
    level_ = now.level;
    centre_ = centre;
    found_ = pyramid_.searches[level_].nearest(centre, count, neighbours_.data(), squared_.data(), reach_);
}

void ScaleLadder::measure(const Point& centre, double k, double largest)
{
    find_neighbours(centre, k, largest);
    const Wanted w = wanted(k);
    const int count = std::min(w.count, found_);
    radius_ = std::sqrt(squared_[count - 1]);
    fit_ = fit_patch(pyramid_.levels[level_], centre, neighbours_.data(), count, radius_, residuals_);
    count_ = count * w.share;
    share_ = w.share;
}

} // namespace recon
