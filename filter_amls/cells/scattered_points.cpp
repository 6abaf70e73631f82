#include "scattered_points.h"

#include "sparse_parts.h"

#include <recon/median.h>
#include <recon/parallel.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

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
                                       const BlockSearch& known_search, const std::vector<double>& reach, int threads)
{
    std::vector<double> usual(known.size());
    parallel_for(
        known.size(), threads, {},
        [&](std::size_t k)
        {
            int near[known_around];
            double squared[known_around];
            known_search.nearest(points[std::size_t(known[k])], known_around, near, squared);
            std::vector<double> around;
            for (const int i : near)
                around.push_back(reach[std::size_t(known[std::size_t(i)])]);
            usual[k] = median(std::move(around));
        },
        1024);
    return usual;
}

/// Per point that may be scattered the usual reach of the known ones around it; 0 of the others.
std::vector<double> list_candidates(const Points& points, const BlockSearch& search, const std::vector<int>& known,
                                    int threads, const Progress& progress)
{
    std::vector<double> reach(points.size()), candidates(points.size());
    parallel_for(
        points.size(), threads, progress.part(0, 0.3),
        [&](std::size_t i) { reach[i] = measure_reach(search, points[i]); }, 1024);
    const double least_reach = of_dense * lower_quartile(reach);
    const BlockSearch known_search(points_at(known, points), threads);
    const std::vector<double> usual_at_known = list_usual_reaches(known, points, known_search, reach, threads);
    parallel_for(
        points.size(), threads, progress.part(0.3, 1),
        [&](std::size_t i)
        {
            const double usual = usual_at_known[std::size_t(known_search.nearest(points[i]))];
            if (reach[i] >= std::max(least_reach, as_far * usual) && !is_on_sheet(points, search, int(i), 0))
                candidates[i] = usual;
        },
        1024);
    return candidates;
}

} // namespace

std::vector<int> with_scattered_points(const Points& points, const BlockSearch& search, std::vector<int> known,
                                       int threads, const Progress& progress)
{
    if (known.size() < std::size_t(known_around) || points.size() <= std::size_t(others))
        return known;
    // Always by those known at first: else what is found near the surface leads on into the tails of its noise.
    const std::vector<double> candidates = list_candidates(points, search, known, threads, progress);
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
                if (candidates[i] > 0 && !is_scattered[i])
                    is_scattered[i] = known_search.has_within(points[i], near_known * candidates[i], known_around);
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
