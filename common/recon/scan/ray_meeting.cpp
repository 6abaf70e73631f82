#include <recon/scan/ray_meeting.h>

#include <recon/scramble.h>

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>

namespace recon
{
namespace
{

/// A gap by the steps before and after it [length by length].
constexpr double wide = 6;
/// See Meeting::spread: 0.004 and more where rays meet.
constexpr double least_spread = 1e-3;
/// Fewer say nothing [count].
constexpr std::size_t fewest_rays = 20;
/// Least share of the gaps whose rays meet; the others are ends of rows, and edges that are not seen from the side.
/// Measured: 0.15 and more of real frames and sweeps, 0.09 of a room with a ball in it; up to 0.38 of models and merged
/// scans, but 0.02 where they are as even as is_of_rows() asks.
constexpr double least_share = 0.05;
/// Angle between both sides of a gap by those of the steps around it: rays next to each other, but for a lost pixel.
constexpr double next_to = 3;
/// Between two rays that are said to meet.
constexpr double least_sine = 0.05;
constexpr int refinements = 6;

struct Ray
{
    Point from;   ///< On the near or the far side.
    Vector along; ///< Of unit length.
    double length;
};

Ray make_ray(const Point& from, const Point& to)
{
    const Vector along = to - from;
    return {from, along.normalized(), along.norm()};
}

/// Both sides of the i-th point, the last before the gap, gone on by one step across it. Without that, rays of left and
/// right edges would pass the scanner on either side.
std::array<Ray, 2> rays_of(const Points& points, std::size_t i)
{
    return {make_ray(2 * points[i] - points[i - 1], points[i + 1]),
            make_ray(points[i], 2 * points[i + 1] - points[i + 2])};
}

/// Half way between two lines where they are nearest; none of nearly parallel ones.
std::optional<Point> meet(const Ray& a, const Ray& b)
{
    const double cosine = a.along.dot(b.along), squared_sine = 1 - cosine * cosine;
    if (squared_sine < least_sine * least_sine)
        return {};
    const Vector between = a.from - b.from;
    const double along_a = a.along.dot(between), along_b = b.along.dot(between);
    return 0.5 * (a.from + (cosine * along_b - along_a) / squared_sine * a.along + b.from +
                  (along_b - cosine * along_a) / squared_sine * b.along);
}

/// Where a random pair of rays meets, the one at which most others do.
std::optional<Point> guess_place(const Points& points, const std::vector<std::size_t>& gaps,
                                 const MeetingTrials& trials)
{
    std::vector<std::size_t> asked;
    for (std::size_t k = 0; k < gaps.size(); k += gaps.size() / trials.asked + 1)
        asked.push_back(gaps[k]);
    std::optional<Point> best;
    std::ptrdiff_t most = 0;
    if (asked.empty())
        return best;
    for (std::size_t trial = 0; trial < trials.pairs; ++trial)
    {
        const auto pick = [&](std::size_t k) { return rays_of(points, asked[scramble(k) % asked.size()])[0]; };
        const std::optional<Point> place = meet(pick(2 * trial), pick(2 * trial + 1));
        if (!place)
            continue;
        const auto found = std::count_if(asked.begin(), asked.end(),
                                         [&](std::size_t gap) { return sees_across(*place, points, gap); });
        if (found > most)
        {
            most = found;
            best = place;
        }
    }
    return best;
}

/// Nearest to the rays that meet about there, by the angles at which they miss it.
Meeting refine(const Points& points, const std::vector<std::size_t>& gaps, Point place)
{
    Meeting result{place, gaps.size()};
    for (int k = 0; k < refinements; ++k)
    {
        Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
        Vector right = Vector::Zero();
        result.rays = 0;
        for (const std::size_t gap : gaps)
        {
            if (!sees_across(result.place, points, gap))
                continue;
            ++result.rays;
            for (const Ray& ray : rays_of(points, gap))
            {
                // Its direction errs by a share of a step over its length.
                const double range = (points[gap] - result.place).norm(), weight = ray.length / (range * range);
                const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray.along * ray.along.transpose();
                matrix += weight * weight * across;
                right += weight * weight * (across * ray.from);
            }
        }
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(matrix);
        result.spread = axes.eigenvalues()[0] / axes.eigenvalues()[2];
        if (!(result.spread > least_spread)) // not a number of too few rays
            return result;
        result.place = matrix.ldlt().solve(right);
    }
    return result;
}

} // namespace

double angle_at(const Point& place, const Point& a, const Point& b)
{
    const Vector to_a = a - place, to_b = b - place;
    return std::atan2(to_a.cross(to_b).norm(), to_a.dot(to_b));
}

std::vector<std::size_t> find_gaps(const Points& points)
{
    std::vector<std::size_t> gaps;
    if (points.size() < 4)
        return gaps;
    const auto step = [&](std::size_t i) { return (points[i + 1] - points[i]).norm(); };
    double before = step(0), here = step(1);
    for (std::size_t i = 1; i + 2 < points.size(); ++i)
    {
        const double after = step(i + 1);
        if (here > wide * std::max(before, after))
            gaps.push_back(i);
        before = here;
        here = after;
    }
    return gaps;
}

bool sees_across(const Point& place, const Points& points, std::size_t gap)
{
    if ((points[gap] - place).dot(points[gap + 1] - place) <= 0)
        return false;
    const auto [least, most] =
        std::minmax({angle_at(place, points[gap - 1], points[gap]), angle_at(place, points[gap + 1], points[gap + 2])});
    return most < next_to * least && angle_at(place, points[gap], points[gap + 1]) < next_to * most;
}

bool Meeting::is_sharp() const
{
    return spread > least_spread;
}

bool Meeting::has_many() const
{
    return rays >= fewest_rays && share() >= least_share;
}

std::optional<Meeting> find_meeting(const Points& points, const std::vector<std::size_t>& gaps,
                                    const MeetingTrials& trials)
{
    const std::optional<Point> guess = guess_place(points, gaps, trials);
    return guess ? std::optional(refine(points, gaps, *guess)) : std::nullopt;
}

} // namespace recon
