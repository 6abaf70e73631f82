#include "isolated_points.h"

#include "surface_cells.h"

#include <recon/median.h>
#include <recon/noise/patch_fit.h>
#include <recon/parallel.h>
#include <recon/search/block_search.h>
#include <recon/search/spatial_order.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace recon
{
namespace
{

/// Distance to the nearest over that of the nearest's own neighbours above which a point is alone. None of the random
/// samples of 58 models is (5,000 and 30,000 each).
constexpr double alone = 2.5;
constexpr int neighbours = 6; // of the nearest
/// Steps of the order, over the median of those around, above which a point is asked at all.
constexpr double long_step = 3;
constexpr std::size_t block = 32;
constexpr std::size_t fewest_points = 100; // that have a surface of their own
constexpr double few_isolated = 0.001;     // of the points: they will have no strays among the others
constexpr double pi = 3.14159265358979323846;
constexpr int stray_neighbours = 20, worst_neighbours = 3; // other strays among these
/// Distance from its neighbours' quadric [their root mean square distances, spacings] from which a point is a stray.
constexpr double stray_heights = 8, stray_off = 0.5;

/// Whether a point lies farther from the nearest than this from its neighbours.
bool is_alone(const Points& points, const BlockSearch& search, std::size_t i)
{
    int near[neighbours + 1];
    double squared[neighbours + 1];
    if (search.nearest(points[i], 2, near, squared) < 2)
        return false;
    const double distance = std::sqrt(squared[1]);
    return search.nearest(points[std::size_t(near[1])], neighbours + 1, near, squared) == neighbours + 1 &&
           distance > alone * std::sqrt(squared[neighbours]);
}

/// Whether some points lie alone. Asks those to which neither the one before nor the one behind in the order is near.
bool may_have_isolated_points(const Points& points, const BlockSearch& search)
{
    const std::size_t n = points.size();
    std::vector<double> steps(n, std::numeric_limits<double>::infinity());
    for (std::size_t i = 1; i < n; ++i)
    {
        const double step = (points[i] - points[i - 1]).norm();
        steps[i - 1] = std::min(steps[i - 1], step);
        steps[i] = step;
    }
    std::vector<double> around;
    for (std::size_t begin = 0, end = 0; begin < n; begin = end)
    {
        end = n < begin + 2 * block ? n : begin + block;
        around.assign(steps.begin() + std::ptrdiff_t(begin), steps.begin() + std::ptrdiff_t(end));
        const double usual = median(around);
        for (std::size_t i = begin; i < end; ++i)
            if (steps[i] > long_step * usual && is_alone(points, search, i))
                return true;
    }
    return false;
}

/// Whether a point lies off the quadric through its neighbours, all but the worst of them, much farther than these.
bool is_stray(const Points& points, const BlockSearch& search, std::size_t i)
{
    const Point& point = points[i];
    std::array<int, 1 + stray_neighbours> near;
    std::array<double, 1 + stray_neighbours> squared;
    if (search.nearest(point, int(near.size()), near.data(), squared.data()) < int(near.size()))
        return false;
    const double radius = std::sqrt(squared.back()), spacing = radius * std::sqrt(pi / stray_neighbours);
    std::vector<PatchResidual> residuals;
    const auto height_of = [&](const PatchFit& fit) { return (fit.foot - point).norm(); };
    if (height_of(fit_patch(points, point, &near[1], stray_neighbours, radius, residuals)) < 0.5 * stray_off * spacing)
        return false;
    std::array<std::pair<double, int>, stray_neighbours> by_height;
    for (std::size_t k = 0; k < by_height.size(); ++k)
        by_height[k] = {std::abs(residuals[k].height), near[1 + k]};
    std::sort(by_height.begin(), by_height.end());
    std::array<int, stray_neighbours - worst_neighbours> best;
    for (std::size_t k = 0; k < best.size(); ++k)
        best[k] = by_height[k].second;
    const PatchFit fit = fit_patch(points, point, best.data(), int(best.size()), radius, residuals);
    return height_of(fit) > std::max(stray_heights * fit.height, stray_off * spacing);
}

/// With points nearer to the surface than isolated ones can be told, where there are isolated ones; none if these are
/// too many.
std::vector<int> with_strays(std::vector<int> isolated, const Points& points, int threads)
{
    const double share = double(isolated.size()) / double(points.size());
    if (share > most_outliers)
        return {};
    if (share < few_isolated)
        return isolated;
    const std::vector<int> others = list_others(points.size(), isolated);
    const Points rest = points_at(others, points);
    const BlockSearch search(rest, threads);
    std::vector<char> strays(rest.size());
    parallel_for(rest.size(), threads, {}, [&](std::size_t i) { strays[i] = is_stray(rest, search, i); });
    for (std::size_t i = 0; i < rest.size(); ++i)
        if (strays[i])
            isolated.push_back(others[i]);
    std::sort(isolated.begin(), isolated.end());
    return isolated;
}

} // namespace

std::vector<int> list_isolated_points(const Points& points, const BlockSearch& search, const Cells& cells,
                                      const CellNormals& normals, int threads)
{
    if (!may_have_isolated_points(points, search))
        return {};
    return with_strays(list_outliers(cells, normals), points, threads);
}

std::vector<int> find_isolated_points(const Points& points, int threads, const Progress& progress)
{
    if (points.size() < fewest_points)
        return {};
    const BlockSearch search(points, threads);
    if (!may_have_isolated_points(points, search))
        return {};
    PhaseTimes times;
    const SurfaceCells made = make_surface_cells(points, search, 0, {}, threads, times, progress);
    return with_strays(list_outliers(made.cells, made.normals), points, threads);
}

std::vector<char> mark_isolated_points(const Points& points, int threads, const Progress& progress)
{
    std::vector<char> marks(points.size(), 0);
    if (points.empty())
        return marks;
    const UnitFrame frame(points);
    const SpatialOrder spatial = order_input(points);
    std::vector<char> is_isolated(spatial.order.size(), 0);
    const Points distinct = frame.to_unit(points_at(spatial.order, points));
    for (const int i : find_isolated_points(distinct, resolve_threads(threads), progress))
        is_isolated[std::size_t(i)] = 1;
    for (std::size_t i = 0; i < points.size(); ++i)
        marks[i] = is_isolated[std::size_t(spatial.representative[i])];
    return marks;
}

} // namespace recon
