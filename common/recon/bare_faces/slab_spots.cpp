#include <recon/bare_faces/slab_spots.h>

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

/// Least radius [noise], and points in it.
constexpr double least_radius = 6;
constexpr int fewest_in_fit = 16;
/// Share of the heights' variance that a slope explains where the surface leans instead of ending.
constexpr double leaning = 0.4;

} // namespace

bool SpotMoments::is_leaning(Leaning told) const
{
    const double explained = slope.dot(spread.ldlt().solve(slope));
    if (told == Leaning::by_share)
        return explained > leaning * variance;
    constexpr double unknowns = 3; // of a plane
    if (!(effective > unknowns))
        return false;
    return (variance - explained) * (effective - 1) < (1 - leaning) * variance * (effective - unknowns);
}

double SlabSpots::choose_radius(const Point& place) const
{
    int indices[fewest_in_fit];
    double squared[fewest_in_fit];
    const int found = search_.nearest(place, fewest_in_fit, indices, squared);
    return std::max(least_radius * noise_, std::sqrt(squared[found - 1]));
}

int SlabSpots::count(const Point& place, double radius)
{
    search_.within(place, radius, near_);
    return int(near_.size());
}

SpotMoments SlabSpots::sum_up(const Point& place, double radius)
{
    SpotMoments result;
    search_.within(place, radius, near_);
    double sum = 0, squares = 0, height = 0;
    std::vector<double> weights;
    for (const int i : near_)
    {
        weights.push_back(std::exp(-8 * (points_.places[i] - place).squaredNorm() / (radius * radius)));
        sum += weights.back();
        squares += weights.back() * weights.back();
        result.mean += weights.back() * points_.places[i];
        height += weights.back() * points_.heights[i];
    }
    if (near_.empty())
        return result;
    result.mean /= sum;
    height /= sum;
    result.effective = sum * sum / squares;
    for (std::size_t k = 0; k < near_.size(); ++k)
    {
        const Eigen::Vector2d off = (points_.places[near_[k]] - result.mean).head<2>();
        const double up = points_.heights[near_[k]] - height;
        result.spread += weights[k] * off * off.transpose();
        result.slope += weights[k] * up * off;
        result.variance += weights[k] * up * up;
    }
    return result;
}

} // namespace recon
