#include <recon/mesh/level_sheet.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

namespace recon
{
namespace
{

/// Points whose tangent planes are tried.
constexpr std::size_t most_trials = 64;
/// Half the thickness of a ground [diagonals of the box], and the least cosine of its normals with the plane's.
constexpr double half_thickness = 0.02, flat = 0.9;
/// Share of all area that lies in a ground, and of its normals' lengths that their sum has: they agree.
constexpr double least_ground = 0.25, agreeing = 0.8;
/// Share of all area that stands out of it, at least, and of that what does so on the things' side.
constexpr double least_things = 0.01, one_sided = 0.75;
/// Share of the things that stand nearer than this share of the way to the rim.
constexpr double within_rim = 0.9, inner = 0.9;
/// Of a floor: least |z| of its normal, share of all else that is on one side of it, and share of it that no ceiling
/// faces.
constexpr double level = 0.95, all_above = 0.9, open_above = 0.5;

/// A plane that may be the ground.
struct Plane
{
    Ground ground;
    double area = 0; ///< Of its members.
};

Plane find_members(const Points& points, const Vectors& normals, const Point& origin, const Vector& normal, double half)
{
    Plane result{{origin, normal, {}}};
    double along = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
    {
        const double area = normals[i].norm(), cosine = normals[i].dot(normal);
        if (std::abs(normal.dot(points[i] - origin)) > half || std::abs(cosine) < flat * area)
            continue;
        result.ground.members.push_back(int(i));
        result.area += area;
        along += cosine;
    }
    if (along < 0)
        result.ground.normal = -normal;
    if (std::abs(along) < agreeing * result.area)
        result.area = 0;
    return result;
}

/// Least squares through the members.
Plane refit(const Points& points, const Vectors& normals, const Plane& plane, double half)
{
    Point centre = Point::Zero();
    for (const int i : plane.ground.members)
        centre += normals[i].norm() / plane.area * points[i];
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const int i : plane.ground.members)
        spread += normals[i].norm() / plane.area * (points[i] - centre) * (points[i] - centre).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
    return find_members(points, normals, centre, solver.eigenvectors().col(0), half);
}

/// \param least_rise of the normals of the points that are tried [0..1].
Plane find_largest_plane(const Points& points, const Vectors& normals, double half, double least_rise = 0)
{
    const std::size_t step = points.size() / most_trials + 1;
    Plane best;
    for (std::size_t i = 0; i < points.size(); i += step)
        if (!normals[i].isZero() && std::abs(normals[i].z()) >= least_rise * normals[i].norm())
        {
            Plane plane = find_members(points, normals, points[i], normals[i].normalized(), half);
            if (plane.area > best.area)
                best = std::move(plane);
        }
    for (int round = 0; round < 2 && best.area > 0; ++round)
        best = refit(points, normals, best, half);
    return best;
}

/// How far the ground reaches in each direction of its plane. Of its convex hull, since the shadow of what stands near
/// the rim notches it.
class Rim
{
public:
    Rim(const Points& points, const Ground& ground) : origin_(ground.origin)
    {
        constexpr double pi = 3.14159265358979323846;
        const Vector first = ground.normal.unitOrthogonal(), second = ground.normal.cross(first);
        for (std::size_t k = 0; k < reach_.size(); ++k)
        {
            const double turn = 2 * pi * double(k) / double(reach_.size());
            reach_[k].direction = std::cos(turn) * first + std::sin(turn) * second;
            for (const int i : ground.members)
                reach_[k].length = std::max(reach_[k].length, reach_[k].direction.dot(points[i] - origin_));
        }
    }
    bool has_within(const Point& p) const
    {
        return std::all_of(reach_.begin(), reach_.end(),
                           [&](const Reach& r) { return r.direction.dot(p - origin_) < inner * r.length; });
    }

private:
    struct Reach
    {
        Vector direction;
        double length = 0;
    };
    Point origin_;
    std::array<Reach, 24> reach_;
};

/// Area of what stands out of a plane, on the side of its normal and on the other.
struct Sides
{
    double before = 0, behind = 0;
};

/// Only of points that are accepted.
template <class Accepts>
Sides measure_sides(const Points& points, const Vectors& normals, const Ground& plane, double half,
                    const Accepts& accepts)
{
    Sides area;
    for (std::size_t i = 0; i < points.size(); ++i)
    {
        const double height = plane.normal.dot(points[i] - plane.origin);
        if (std::abs(height) > half && accepts(points[i]))
            (height < 0 ? area.behind : area.before) += normals[i].norm();
    }
    return area;
}

Sides measure_sides(const Points& points, const Vectors& normals, const Ground& plane, double half)
{
    return measure_sides(points, normals, plane, half, [](const Point&) { return true; });
}

Vector sum_of(const Vectors& vectors)
{
    return std::accumulate(vectors.begin(), vectors.end(), Vector(Vector::Zero()));
}

double sum_of_lengths(const Vectors& vectors)
{
    return std::accumulate(vectors.begin(), vectors.end(), 0.0,
                           [](double sum, const Vector& v) { return sum + v.norm(); });
}

/// Whether the floor of a room or street without a ceiling, seen from within, turns its back to what stands on it: a
/// level plane that faces down though all else is above. Of a closed surface all area cancels.
bool has_floor_that_faces_down(const Points& points, const Vectors& normals)
{
    const double half = half_thickness * bounding_box(points).diagonal();
    const Plane floor = find_largest_plane(points, normals, half, level);
    if (floor.area < least_ground * sum_of_lengths(normals) || floor.ground.normal.z() > -level ||
        sum_of(normals).z() > -open_above * floor.area)
        return false;
    const Sides area = measure_sides(points, normals, floor.ground, half);
    return area.behind > all_above * (area.before + area.behind);
}

} // namespace

Vectors times_area(Vectors normals, const std::vector<double>& spacing)
{
    for (std::size_t i = 0; i < normals.size(); ++i)
        normals[i] *= spacing[i] * spacing[i];
    return normals;
}

std::optional<Ground> find_ground(const Points& points, const Vectors& normals)
{
    const double all = sum_of_lengths(normals);
    const double half = half_thickness * bounding_box(points).diagonal();
    Plane plane = find_largest_plane(points, normals, half);
    if (!(plane.area > 0) || plane.area < least_ground * all)
        return {};
    Ground& ground = plane.ground;
    const Rim rim(points, ground);
    const Sides area = measure_sides(points, normals, ground, half);
    const Sides within =
        measure_sides(points, normals, ground, half, [&](const Point& p) { return rim.has_within(p); });
    ground.faces_things = area.before > area.behind;
    const double things = ground.faces_things ? area.before : area.behind;
    if (things < std::max(least_things * all, one_sided * (area.before + area.behind)) ||
        (ground.faces_things ? within.before : within.behind) < within_rim * things)
        return {};
    return std::move(ground);
}

bool is_upside_down(const Points& points, const Vectors& normals)
{
    constexpr double most_height = 0.25; // of the length and the width
    constexpr double least_rise = 0.6;   // of the normals' mean: a dome has .5
    const Box box = bounding_box(points);
    const Vector extent = box.maximum - box.minimum;
    if (extent.z() > most_height * std::min(extent.x(), extent.y()))
    {
        const std::optional<Ground> ground = find_ground(points, normals);
        return ground ? !ground->faces_things : has_floor_that_faces_down(points, normals);
    }
    return sum_of(normals).z() < -least_rise * sum_of_lengths(normals);
}

} // namespace recon
