#include "mouths.h"

#include <recon/parallel.h>

#include <algorithm>
#include <cmath>

namespace recon::pn
{
namespace
{

constexpr double upright = 0.5;                 ///< Largest cosine between the normals of a wall and of the face.
constexpr double shallowest = 0.1, deepest = 2; ///< Of what is counted as a wall, from the face [spacings].
constexpr double farthest_wall = 1.5;           ///< Along the face, of a bore's [spacings],
constexpr double farthest_foot = 1;             ///< of a rib's: farther away it finds those of bores around a point.
constexpr double covered = 1.2;                 ///< A sheet so near along the face hides what is deeper [spacings].
constexpr double faced = 0.15;                  ///< Mean sine of the angles between walls and the way from them to x.
constexpr int least_walls = 2;
constexpr double longest_side = 3; ///< Of triangles across a mouth, from a corner to a wall [spacings].

struct Wall
{
    Point point;
    Vector normal;
    double depth, along; ///< Of the point below and along the face [spacings].
    double before;       ///< How far x lies before the wall's plane [spacings].
    double sine;         ///< Of the angle between the wall and the way to x.
};

/// The walls below a face at x, and how deep they count. \param side 1: as they are; -1: of the solid turned inside
/// out, where ribs are slits.
struct Walls
{
    std::vector<Wall> list;
    double floor = deepest; ///< What lies below belongs to what is on the other side of a sheet.

    void find(const OrientedSamples& samples, const std::vector<int>& near, const Point& x, const Vector& normal,
              double spacing, double side)
    {
        list.clear();
        floor = deepest;
        const double farthest = side > 0 ? farthest_wall : farthest_foot;
        for (int j : near)
        {
            const Point& point = samples.points[std::size_t(j)];
            const Vector &n = samples.normals[std::size_t(j)], d = x - point;
            const double height = d.dot(normal), depth = side * height / spacing,
                         along = (d - height * normal).norm() / spacing, agreement = n.dot(normal);
            if (agreement < -upright && depth > 0 && along < covered)
                floor = std::min(floor, depth);
            else if (std::abs(agreement) < upright && depth > shallowest && along < farthest)
                list.push_back({point, n, depth, along, side * d.dot(n) / spacing, side * d.dot(n) / d.norm()});
        }
    }

    /// Whether it is the far side of a rib whose near side x sees.
    bool is_hidden(const Wall& wall, double spacing, double side) const
    {
        const auto hides = [&](const Wall& other)
        {
            return other.before > 0.02 && other.depth < floor && other.normal.dot(wall.normal) < -upright &&
                   side * (wall.point - other.point).dot(other.normal) < -0.05 * spacing;
        };
        return wall.before < 0 && std::any_of(list.begin(), list.end(), hides);
    }

    /// Whether the walls, above all the nearest, face x.
    bool face_point(double spacing, double side) const
    {
        int count = 0;
        double sum = 0, weights = 0;
        for (const Wall& wall : list)
        {
            if (wall.depth >= floor || is_hidden(wall, spacing, side))
                continue;
            const double distance = (std::abs(wall.before) + 0.1) * (wall.along + 0.1),
                         weight = 1 / (distance * std::sqrt(distance) * (1 + wall.depth * wall.depth));
            sum += weight * wall.sine;
            weights += weight;
            ++count;
        }
        return count >= least_walls && sum > faced * weights;
    }
};

} // namespace

Mouths::Mouths(const UsableSamples& usable, const std::vector<float>& spacing, int threads, const Progress& progress)
    : samples_(usable.samples), search_(samples_.points), is_near_(usable.samples.points.size())
{
    parallel_for(
        is_near_.size(), threads, progress, [&](std::size_t i) { is_near_[i] = is_near_some(i, double(spacing[i])); },
        256);
}

bool Mouths::is_near_some(std::size_t i, double spacing) const
{
    thread_local std::vector<int> near;
    search_.within(samples_.points[i], longest_side * spacing, near);
    const auto is_wall = [&](int j)
    {
        const Vector &face = samples_.normals[i], &wall = samples_.normals[std::size_t(j)];
        const Vector d = samples_.points[i] - samples_.points[std::size_t(j)];
        const double height = d.dot(face), before = d.dot(wall);
        return std::abs(wall.dot(face)) < upright && std::abs(height) > shallowest * spacing && height * before > 0 &&
               std::abs(before) > faced * d.norm();
    };
    return std::any_of(near.begin(), near.end(), is_wall);
}

bool Mouths::are_near(std::size_t i, const UsableSamples& usable) const
{
    const auto beside = [&](std::size_t k) { return std::size_t(usable.beside[k]); };
    while (i >= is_near_.size())
        i = beside(i);
    return is_near_[i] || is_near_[beside(i)];
}

bool Mouths::hold(const Point& x, const Vector& normal, double spacing) const
{
    thread_local std::vector<int> near;
    thread_local Walls walls;
    search_.within(x, std::hypot(deepest, farthest_wall) * spacing, near);
    for (double side : {1., -1.})
    {
        walls.find(samples_, near, x, normal, spacing, side);
        if (walls.face_point(spacing, side))
            return true;
    }
    return false;
}

} // namespace recon::pn
