#include <recon/scan/depth_image.h>

#include <recon/median.h>
#include <recon/search/neighbours.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace recon
{
namespace
{

constexpr std::size_t most_asked = 1'000;
/// Fewer say nothing [count].
constexpr std::size_t fewest = 100;
/// Least cosine between the axis and any ray: a camera sees 66 degrees to each side at most.
constexpr double least_cosine = 0.4;
/// Share of the points whose nearest in the image is as far as the median, within a twentieth: 1 of a frame, 0.15 of
/// one that was moved, 0.03 to 0.07 of models and of a scan, 0.08 to 0.36 of planes with a grid of their own.
constexpr double on_grid = 0.8, even = 0.05;
/// Farthest depth by the nearest, but for a twentieth of the points each.
constexpr double least_relief = 1.25;
/// Relative difference of equal depths, and share of the points up to which different ones come in steps.
constexpr double equal_depths = 1e-6, few_depths = 0.1;
/// Depths on either side that tell the step [count]; steps that are coarse [pixels].
constexpr std::ptrdiff_t around = 2;
constexpr double coarse = 0.5;
/// Points asked whether they lie in a step [count], and share in steps that makes a cloud coarse.
constexpr int neighbours = 12;
constexpr double many_in_steps = 0.1;

/// Where the rays meet a plane at depth 1. Empty if some do not, or not all on one side.
Points list_pixels(const Points& points, int axis)
{
    Points pixels;
    const double side = points.front()[axis] < 0 ? -1 : 1;
    for (const Point& p : points)
    {
        const double depth = side * p[axis];
        if (!(depth > least_cosine * p.norm()))
            return {};
        pixels.emplace_back(p[(axis + 1) % 3] / depth, p[(axis + 2) % 3] / depth, 0);
    }
    return pixels;
}

bool has_relief(const Points& points, int axis)
{
    std::vector<double> depths;
    for (const Point& p : points)
        depths.push_back(std::abs(p[axis]));
    return quantile(depths, 0.95) > least_relief * quantile(depths, 0.05);
}

/// Distance of neighbours in the image; 0 if they are on no grid.
double measure_pixel(const Points& pixels)
{
    const NeighbourSearch search(pixels);
    std::vector<double> steps;
    for (std::size_t i = 0; i < pixels.size(); i += pixels.size() / most_asked + 1)
    {
        int nearest[2];
        double squared[2];
        search.nearest(pixels[i], 2, nearest, squared);
        steps.push_back(std::sqrt(squared[1]));
    }
    const double usual = median(steps);
    const auto alike =
        std::count_if(steps.begin(), steps.end(), [&](double step) { return std::abs(step - usual) <= even * usual; });
    return double(alike) >= on_grid * double(steps.size()) ? usual : 0;
}

/// Depths that occur, ascending; none if they are many.
std::vector<double> list_depths(const Points& points, int axis)
{
    std::vector<double> depths;
    for (const Point& p : points)
        depths.push_back(std::abs(p[axis]));
    std::sort(depths.begin(), depths.end());
    const auto are_equal = [](double a, double b) { return b - a <= equal_depths * b; };
    depths.erase(std::unique(depths.begin(), depths.end(), are_equal), depths.end());
    if (double(depths.size()) > few_depths * double(points.size()))
        depths.clear();
    return depths;
}

/// Whether some of a thousand points have equal coordinates, as in steps and in planes along the axes.
bool has_equal_depths(const Points& points)
{
    for (int axis = 0; axis < 3; ++axis)
    {
        std::vector<double> depths;
        for (std::size_t i = 0; i < points.size(); i += points.size() / most_asked + 1)
            depths.push_back(points[i][axis]);
        const std::size_t asked = depths.size();
        std::sort(depths.begin(), depths.end());
        depths.erase(std::unique(depths.begin(), depths.end()), depths.end());
        if (double(depths.size()) < 0.9 * double(asked))
            return true;
    }
    return false;
}

} // namespace

double DepthCamera::step_at(const Point& p) const
{
    if (depths.size() < 2)
        return 0;
    const std::ptrdiff_t last = std::ptrdiff_t(depths.size()) - 1,
                         at = std::lower_bound(depths.begin(), depths.end(), ahead.dot(p - place)) - depths.begin();
    // Some depths may not occur, so steps look like multiples of their length.
    double least = std::numeric_limits<double>::infinity();
    for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(at - around, 0); i < std::min(at + around, last); ++i)
        least = std::min(least, depths[std::size_t(i + 1)] - depths[std::size_t(i)]);
    return std::isfinite(least) ? least : 0;
}

bool DepthCamera::is_in_step(const Point& p, const Points& points, const BlockSearch& search) const
{
    int near[neighbours];
    double squared[neighbours];
    const int count = search.nearest(p, neighbours, near, squared);
    const double depth = ahead.dot(p - place);
    const auto equal = std::count_if(
        near, near + count,
        [&](int i) { return std::abs(ahead.dot(points[std::size_t(i)] - place) - depth) <= 2 * equal_depths * depth; });
    return 4 * equal >= 3 * count;
}

DepthCamera DepthCamera::in(const UnitFrame& frame) const
{
    DepthCamera result = *this;
    result.place = frame.to_unit(place);
    for (double& depth : result.depths)
        depth /= frame.scale();
    return result;
}

std::optional<DepthCamera> find_depth_camera(const Points& points)
{
    if (points.size() < fewest)
        return {};
    for (int axis = 0; axis < 3; ++axis)
    {
        const Points pixels = list_pixels(points, axis);
        if (pixels.empty() || !has_relief(points, axis))
            continue;
        const double pixel = measure_pixel(pixels);
        if (pixel > 0)
            return DepthCamera{Point::Zero(), (points.front()[axis] < 0 ? -1 : 1) * Vector::Unit(axis), pixel,
                               list_depths(points, axis)};
    }
    return {};
}

std::optional<DepthCamera> find_coarse_depth_camera(const Points& points)
{
    if (points.size() < fewest || !has_equal_depths(points))
        return {};
    std::optional<DepthCamera> camera = find_depth_camera(points);
    if (!camera || camera->depths.empty())
        return {};
    const BlockSearch search(points);
    int in_steps = 0, asked = 0;
    for (std::size_t i = 0; i < points.size(); i += points.size() / most_asked + 1, ++asked)
        in_steps += camera->step_at(points[i]) >= coarse * camera->pixel * camera->ahead.dot(points[i]) &&
                    camera->is_in_step(points[i], points, search);
    return in_steps > many_in_steps * asked ? camera : std::nullopt;
}

} // namespace recon
