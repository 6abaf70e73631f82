#include <recon/viewpoint.h>

#include <recon/depth_image.h>
#include <recon/median.h>
#include <recon/neighbours.h>
#include <recon/scramble.h>

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace recon
{
namespace
{

/// Fewer points or gaps say nothing [count].
constexpr std::size_t fewest_points = 100, fewest_gaps = 20;
/// A gap by the steps before and after it [length by length].
constexpr double wide = 6;
/// Least share of the gaps whose rays meet; the others are ends of rows, and edges that are not seen from the side.
/// Measured: 0.15 and more of real frames and sweeps, 0.09 of a room with a ball in it; up to 0.38 of models and merged
/// scans, but 0.02 where they are as even as below.
constexpr double least_share = 0.05;
/// Least share of the points as far from the next as that from the one after it, within a fifth: 0.97 and more of
/// frames and sweeps, 0.91 of models at most.
constexpr double even = 0.2, on_rows = 0.93;
/// Least by largest eigenvalue of the rays' normal equations: 0.004 and more where they meet; 0 of parallel ones.
constexpr double least_spread = 1e-3;
/// Angle between both sides of a gap by those of the steps around it: rays next to each other, but for a lost pixel.
constexpr double next_to = 3;
/// Pairs of rays that are tried, gaps that have a say in which is the best, and least sine between two rays.
constexpr std::size_t trials = 400, most_asked = 200;
constexpr double least_sine = 0.05;
constexpr int refinements = 6;
constexpr std::size_t most_measured = 4'000;
constexpr double least_angle = 1e-300;
/// Of so many points [count], the largest share of which half of those around in the image, itself among them, are so
/// much nearer or farther: up to 0.03 of frames and sweeps, 0.37 of a room from outside.
constexpr std::size_t most_seen = 20'000;
constexpr int around = 9;
constexpr double behind = 1.1, most_hidden = 0.06;
/// Places that are tried, each by the gaps that the former do not see across.
constexpr int places = 3;

double angle_at(const Point& place, const Point& a, const Point& b)
{
    const Vector to_a = a - place, to_b = b - place;
    return std::atan2(to_a.cross(to_b).norm(), to_a.dot(to_b));
}

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

/// Indices of the points before them.
std::vector<std::size_t> find_gaps(const Points& points)
{
    std::vector<std::size_t> gaps;
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

/// Whether a place sees both sides of a gap next to each other.
bool sees_across(const Point& place, const Points& points, std::size_t gap)
{
    if ((points[gap] - place).dot(points[gap + 1] - place) <= 0)
        return false;
    const double around =
        std::max(angle_at(place, points[gap - 1], points[gap]), angle_at(place, points[gap + 1], points[gap + 2]));
    return angle_at(place, points[gap], points[gap + 1]) < next_to * around;
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
std::optional<Point> guess_place(const Points& points, const std::vector<std::size_t>& gaps)
{
    std::vector<std::size_t> asked;
    for (std::size_t k = 0; k < gaps.size(); k += gaps.size() / most_asked + 1)
        asked.push_back(gaps[k]);
    std::optional<Point> best;
    std::ptrdiff_t most = 0;
    for (std::size_t trial = 0; trial < trials; ++trial)
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

struct Meeting
{
    Point place;
    std::size_t rays = 0; ///< Gaps that are seen from there [count].
    double spread = 0;    ///< See least_spread.
};

/// Nearest to the rays that meet about there, by the angles at which they miss it.
Meeting refine(const Points& points, const std::vector<std::size_t>& gaps, Point place)
{
    Meeting result{place};
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

/// What a place sees of neighbours.
struct Evenness
{
    double share = 0;     ///< Of points as far from the next as that from the one after it, see `even`.
    double deviation = 1; ///< Median relative difference of these angles.
};

Evenness measure_evenness(const Points& points, const Point& place)
{
    std::vector<double> deviations;
    for (std::size_t i = 1; i + 1 < points.size(); i += points.size() / most_measured + 1)
    {
        const double before = angle_at(place, points[i - 1], points[i]),
                     after = angle_at(place, points[i], points[i + 1]);
        deviations.push_back(std::abs(before - after) / std::max({before, after, least_angle}));
    }
    const auto alike = std::count_if(deviations.begin(), deviations.end(), [](double d) { return d <= even; });
    return {double(alike) / double(deviations.size()), median(deviations)};
}

/// Whether what is seen next to each other lies at one distance, but for gaps; else there is something in between.
bool sees_all(const Points& points, const Point& place)
{
    Points directions;
    std::vector<double> ranges;
    for (std::size_t i = 0; i < points.size(); i += points.size() / most_seen + 1)
    {
        const Vector ray = points[i] - place;
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
        const auto far = std::count_if(
            near, near + found,
            [&](int k) { return std::abs(std::log(ranges[std::size_t(k)] / ranges[i])) > std::log(behind); });
        hidden += 2 * far >= around - 1;
    }
    return hidden <= most_hidden * asked;
}

/// The place from which all points follow each other evenly. Ends of rows can meet elsewhere, too: those of a floor and
/// a wall are as two views of one line.
std::optional<Point> choose_place(const Points& points, std::vector<std::size_t> gaps)
{
    std::optional<Point> best;
    double least_deviation = std::numeric_limits<double>::infinity();
    for (int k = 0; k < places && gaps.size() >= fewest_gaps; ++k)
    {
        const std::optional<Point> guess = guess_place(points, gaps);
        if (!guess)
            break;
        const Meeting meeting = refine(points, gaps, *guess);
        if (meeting.rays < fewest_gaps || double(meeting.rays) < least_share * double(gaps.size()))
            break;
        const Evenness seen = measure_evenness(points, meeting.place);
        if (meeting.spread > least_spread && seen.share >= on_rows && seen.deviation < least_deviation &&
            sees_all(points, meeting.place))
        {
            best = meeting.place;
            least_deviation = seen.deviation;
        }
        gaps.erase(std::remove_if(gaps.begin(), gaps.end(),
                                  [&](std::size_t gap) { return sees_across(meeting.place, points, gap); }),
                   gaps.end());
    }
    return best;
}

} // namespace

std::optional<Point> find_scan_origin(const Points& points)
{
    if (points.size() < fewest_points)
        return {};
    // About one of them, lest a far coordinate system costs digits; without copies.
    const Point middle = points[points.size() / 2];
    Points apart{points.front() - middle};
    for (const Point& p : points)
        if (p - middle != apart.back())
            apart.push_back(p - middle);
    if (apart.size() < fewest_points)
        return {};
    std::optional<Point> origin = choose_place(apart, find_gaps(apart));
    if (origin)
        *origin += middle;
    return origin;
}

std::optional<Point> find_viewpoint(const Points& points, const Points& sorted)
{
    if (const auto camera = find_depth_camera(sorted))
        return camera->place;
    return find_scan_origin(points);
}

std::optional<Point> find_viewpoint(const Points& points)
{
    return find_viewpoint(points, points);
}

} // namespace recon
