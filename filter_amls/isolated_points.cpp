#include "isolated_points.h"

#include "surface_cells.h"

#include <recon/block_search.h>
#include <recon/median.h>
#include <recon/parallel.h>
#include <recon/spatial_order.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recon
{
namespace
{

/// Distance to the nearest over that of the nearest's own neighbours above which a point is alone. Random samples of a
/// surface reach 2.5 once in 10^8 times.
constexpr double alone = 2.5;
constexpr int neighbours = 6; // of the nearest
/// Steps of the order, over the median of those around, above which a point is asked at all.
constexpr double long_step = 3;
constexpr std::size_t block = 32;
constexpr std::size_t fewest_points = 100; // that have a surface of their own
constexpr double most_isolated = 0.3;      // of the points: else they are no surface

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
bool may_have_isolated_points(const Points& points)
{
    const std::size_t n = points.size();
    std::vector<double> steps(n, std::numeric_limits<double>::infinity());
    for (std::size_t i = 1; i < n; ++i)
    {
        const double step = (points[i] - points[i - 1]).norm();
        steps[i - 1] = std::min(steps[i - 1], step);
        steps[i] = step;
    }
    const BlockSearch search(points);
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

std::vector<int> drop_if_many(std::vector<int> isolated, const Points& points)
{
    if (double(isolated.size()) > most_isolated * double(points.size()))
        isolated.clear();
    return isolated;
}

} // namespace

std::vector<int> list_isolated_points(const Points& points, const Cells& cells, const CellNormals& normals)
{
    if (!may_have_isolated_points(points))
        return {};
    return drop_if_many(list_outliers(cells, normals), points);
}

std::vector<int> find_isolated_points(const Points& points, int threads, const Progress& progress)
{
    if (points.size() < fewest_points || !may_have_isolated_points(points))
        return {};
    PhaseTimes times;
    const SurfaceCells made = make_cells_twice(points, BlockSearch(points), 0, threads, times, progress);
    return drop_if_many(list_outliers(made.cells, made.normals), points);
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
