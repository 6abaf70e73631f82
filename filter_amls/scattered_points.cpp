#include "scattered_points.h"

#include "sparse_parts.h"

#include <recon/parallel.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace recon
{
namespace
{

/// What is called the reach of a point is its distance to so many others.
constexpr int others = 8;
/// Of the known ones around, so many, the median reach is usual.
constexpr int known_around = 12;
/// Least reach, and largest distance to so many known ones [usual reaches]. The reach of points scattered evenly varies
/// by an eighth.
constexpr double as_far = 0.65, near_known = 4;
/// Least reach by that which a quarter of the points have at most: else the seldom lone samples of thin, sparse walls
/// would make outliers of those.
constexpr double of_dense = 1.5;
constexpr int passes = 3;

double lower_quartile(std::vector<double> values)
{
    const auto at = values.begin() + std::ptrdiff_t(values.size() / 4);
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

double measure_reach(const BlockSearch& search, const Point& point)
{
    int near[others + 1];
    double squared[others + 1];
    search.nearest(point, others + 1, near, squared);
    return std::sqrt(squared[others]);
}

/// Per known point the median reach of the known ones around it.
std::vector<double> list_usual_reaches(const std::vector<int>& known, const Points& points,
                                       const BlockSearch& known_search, const std::vector<double>& reach)
{
    std::vector<double> usual;
    for (const int i : known)
    {
        int near[known_around];
        double squared[known_around], around[known_around];
        known_search.nearest(points[std::size_t(i)], known_around, near, squared);
        std::transform(near, near + known_around, around,
                       [&](int k) { return reach[std::size_t(known[std::size_t(k)])]; });
        std::nth_element(around, around + known_around / 2, around + known_around);
        usual.push_back(around[known_around / 2]);
    }
    return usual;
}

} // namespace

std::vector<int> with_scattered_points(const Points& points, const BlockSearch& search, std::vector<int> known,
                                       int threads)
{
    if (known.size() < std::size_t(known_around) || points.size() <= std::size_t(others))
        return known;
    // Always by those known at first: else what is found near the surface leads on into the tails of its noise.
    std::vector<double> reach(points.size()), usual(points.size());
    parallel_for(
        points.size(), threads, {}, [&](std::size_t i) { reach[i] = measure_reach(search, points[i]); }, 1024);
    const double least_reach = of_dense * lower_quartile(reach);
    std::vector<char> may_be(points.size());
    {
        // Always by those known at first: else what is found near the surface leads on into the tails of its noise.
        const BlockSearch first_search(points_at(known, points), threads);
        const std::vector<double> usual_at_first = list_usual_reaches(known, points, first_search, reach);
        parallel_for(
            points.size(), threads, {},
            [&](std::size_t i)
            {
                usual[i] = usual_at_first[std::size_t(first_search.nearest(points[i]))];
                may_be[i] =
                    reach[i] >= std::max(least_reach, as_far * usual[i]) && !is_on_sheet(points, search, int(i), 0);
            },
            1024);
    }
    std::vector<char> is_scattered(points.size());
    for (const int i : known)
        is_scattered[std::size_t(i)] = 1;
    for (int pass = 0; pass < passes; ++pass)
    {
        const BlockSearch known_search(points_at(known, points), threads);
        parallel_for(
            points.size(), threads, {},
            [&](std::size_t i)
            {
                if (may_be[i] && !is_scattered[i])
                    is_scattered[i] = known_search.has_within(points[i], near_known * usual[i], known_around);
            },
            1024);
        const std::size_t before = known.size();
        known.clear();
        for (std::size_t i = 0; i < points.size(); ++i)
            if (is_scattered[i])
                known.push_back(int(i));
        if (known.size() == before)
            break;
    }
    return known;
}

} // namespace recon
