#include <recon/depth_image.h>

#include <recon/neighbours.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace recon
{
namespace
{

constexpr std::size_t most_asked = 1'000;
/// Fewer say nothing [count].
constexpr std::size_t fewest = 100;
/// Least cosine between the axis and any ray: cameras see 60 degrees to each side at most.
constexpr double least_cosine = 0.4;
/// Share of the points whose nearest in the image is as far as that of most, within a twentieth; of samples anywhere,
/// and of grids seen aslant, it is a tenth to a half.
constexpr double on_grid = 0.8, even = 0.05;
/// Farthest depth by the nearest, but for a twentieth of the points each.
constexpr double least_relief = 1.25;

double quantile(std::vector<double> values, double share)
{
    const auto at = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

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

bool are_on_grid(const Points& pixels)
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
    const double usual = quantile(steps, 0.5);
    const auto alike =
        std::count_if(steps.begin(), steps.end(), [&](double step) { return std::abs(step - usual) <= even * usual; });
    return usual > 0 && double(alike) >= on_grid * double(steps.size());
}

} // namespace

std::optional<Point> find_depth_camera(const Points& points)
{
    if (points.size() < fewest)
        return {};
    for (int axis = 0; axis < 3; ++axis)
        if (const Points pixels = list_pixels(points, axis);
            !pixels.empty() && has_relief(points, axis) && are_on_grid(pixels))
            return Point(Point::Zero());
    return {};
}

} // namespace recon
