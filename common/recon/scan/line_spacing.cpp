#include <recon/scan/line_spacing.h>

#include <recon/parallel.h>
#include <recon/search/neighbours.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace recon
{
namespace
{

/// Neighbours among which the next line is sought [count]: some of it are among them where readings are up to a
/// fortieth of the angle between lines apart.
constexpr int around = 80;
/// Between a surface and the rays that see it, at least [radians].
constexpr double most_grazing = 0.05;
/// Cosine below which a direction is across another.
constexpr double across = 0.5;

/// Samples that were seen from one place, and where.
struct Seen
{
    Point place;
    std::vector<int> samples;
    Points directions;
};

std::vector<Seen> sort_by_place(const Points& samples, const Viewpoints& viewpoints)
{
    std::vector<Seen> result;
    if (viewpoints.empty())
        return result;
    for (const Point& place : viewpoints.places())
        result.push_back({place, {}, {}});
    for (std::size_t i = 0; i < samples.size(); ++i)
    {
        const Point& place = viewpoints.of(samples[i]);
        if (samples[i] == place)
            continue;
        Seen& seen = result[std::size_t(&place - viewpoints.places().data())];
        seen.samples.push_back(int(i));
        seen.directions.push_back((samples[i] - place).normalized());
    }
    return result;
}

/// \param k of what was seen. \param search of its directions.
double find_next_line(std::size_t k, const Points& samples, const Seen& seen, const NeighbourSearch& search)
{
    std::array<int, around> nearest;
    std::array<double, around> squared;
    const Point& sample = samples[seen.samples[k]];
    const double range = (sample - seen.place).norm();
    const int found = search.nearest(seen.directions[k], around, nearest.data(), squared.data());
    Vector along = Vector::Zero();
    double next = std::numeric_limits<double>::infinity();
    for (int i = 0; i < found; ++i)
    {
        const double angle = std::sqrt(squared[i]);
        if (angle == 0)
            continue;
        const Vector step = (seen.directions[nearest[i]] - seen.directions[k]) / angle;
        if (along.isZero())
            along = step;
        const double distance = (samples[seen.samples[nearest[i]]] - sample).norm();
        if (std::abs(along.dot(step)) <= across && distance * most_grazing < range * angle)
            next = std::min(next, distance);
    }
    return std::isfinite(next) ? next : 0;
}

} // namespace

std::vector<double> measure_line_spacing(const Points& samples, const Viewpoints& viewpoints, int threads,
                                         const Progress& progress)
{
    std::vector<double> spacing(samples.size(), 0);
    const std::vector<Seen> by_place = sort_by_place(samples, viewpoints);
    const double places = double(by_place.size());
    for (std::size_t i = 0; i < by_place.size(); ++i)
    {
        const Seen& seen = by_place[i];
        const NeighbourSearch search(seen.directions);
        parallel_for(seen.samples.size(), threads, progress.part(double(i) / places, double(i + 1) / places),
                     [&](std::size_t k) { spacing[seen.samples[k]] = find_next_line(k, samples, seen, search); });
    }
    return spacing;
}

} // namespace recon
