#pragma once

#include <recon/geometry.h>
#include <recon/search/neighbours.h>

#include <Eigen/Core>

#include <vector>

namespace recon
{

/// Points whose heights around a place lean with it are no rim's: the surface crosses the plane there.
enum class Leaning
{
    by_share,     ///< By the share of the variance that a slope explains; of a lone spot's few points it may by chance.
    beyond_chance ///< Less what it would explain of as many heights by chance: for sparse rims.
};

/// Points in the slab of a noisy plane.
struct SlabPoints
{
    Points places; ///< In the plane, over two of its directions; z is 0 [length].
    std::vector<double> heights;
};

/// Weighted moments of the points of a slab around a place.
struct SpotMoments
{
    Point mean = Point::Zero(); ///< Of the places.
    Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
    Eigen::Vector2d slope = Eigen::Vector2d::Zero(); ///< Of heights with places.
    double variance = 0;                             ///< Of heights.
    double effective = 0; ///< As many points of equal weight would say as much; 0: none is near [count].

    /// Whether heights lean with the place.
    bool is_leaning(Leaning told) const;
};

/// Finds the points of a slab around places in it.
class SlabSpots
{
public:
    /// \param points outlive this object. \param noise standard deviation > 0.
    SlabSpots(const SlabPoints& points, double noise) : points_(points), noise_(noise), search_(points.places) {}

    /// Radius in which enough points say where a curve runs.
    double choose_radius(const Point& place) const;
    int count(const Point& place, double radius);
    SpotMoments sum_up(const Point& place, double radius);

private:
    const SlabPoints& points_;
    double noise_;
    NeighbourSearch search_;
    std::vector<int> near_;
};

} // namespace recon
