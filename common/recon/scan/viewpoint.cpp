#include <recon/scan/viewpoint.h>

#include <recon/median.h>
#include <recon/scan/depth_image.h>
#include <recon/scan/even_angles.h>
#include <recon/scan/ray_meeting.h>
#include <recon/scan/scan_rows.h>
#include <recon/scan/scan_splitter.h>
#include <recon/search/neighbours.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

namespace recon
{
namespace
{

/// Fewer points say nothing [count].
constexpr std::size_t fewest_points = 100;
/// Places that are tried, each by the gaps that the former do not see across.
constexpr int trials = 3;

/// Share of the points that must be of scans with a place, or lie where theirs do.
constexpr double nearly_all = 0.9;
constexpr std::size_t most_measured = 2'000;
/// A place that the order tells, so near to the origin, may be the origin [1 = median range].
constexpr double beside_origin = 0.02;
/// Copies of a point below which they may be chance [count].
constexpr std::size_t fewest_copies = 100;
/// Points by which scans are told apart [count].
constexpr std::size_t most_marks = 200'000;

/// About one of them, lest a far coordinate system costs digits; without copies.
struct DistinctRun
{
    explicit DistinctRun(const Points& all)
    {
        if (all.size() < fewest_points)
            return;
        middle = all[all.size() / 2];
        points.push_back(all.front() - middle);
        for (const Point& p : all)
            if (p - middle != points.back())
                points.push_back(p - middle);
        if (points.size() < fewest_points)
            points.clear();
    }
    Point middle = Point::Zero();
    Points points; ///< None of too few.
};

void drop_seen(const Point& place, const Points& points, std::vector<std::size_t>& gaps)
{
    gaps.erase(
        std::remove_if(gaps.begin(), gaps.end(), [&](std::size_t gap) { return sees_across(place, points, gap); }),
        gaps.end());
}

/// The place from which all points follow each other evenly. Ends of rows can meet elsewhere, too: those of a floor and
/// a wall are as two views of one line.
std::optional<Point> choose_place(const Points& points, std::vector<std::size_t> gaps)
{
    std::optional<Point> best;
    double least_deviation = std::numeric_limits<double>::infinity();
    for (int k = 0; k < trials; ++k)
    {
        const std::optional<Meeting> meeting = find_meeting(points, gaps);
        if (!meeting || !meeting->has_many())
            break;
        const Evenness seen = measure_evenness(points, meeting->place);
        if (meeting->is_sharp() && seen.deviation < least_deviation &&
            (seen.is_exact() || (seen.is_of_rows() && sees_all(points, meeting->place))))
        {
            best = meeting->place;
            least_deviation = seen.deviation;
        }
        drop_seen(meeting->place, points, gaps);
    }
    return best;
}

/// Share of the points that are of scans with a place, or lie where theirs do. \param scans in order. \param seen their
/// points, or some of them.
double measure_cover(const Points& points, const std::vector<Scan>& scans, const Points& seen)
{
    constexpr double within = 2; // spacings
    const NeighbourSearch search(seen);
    std::size_t covered = 0, asked = 0;
    auto scan = scans.begin();
    for (std::size_t i = 0; i < points.size(); i += points.size() / most_measured + 1, ++asked)
    {
        while (scan != scans.end() && scan->end <= i)
            ++scan;
        if (scan != scans.end() && scan->begin <= i)
        {
            ++covered;
            continue;
        }
        const Point& nearest = seen[std::size_t(search.nearest(points[i]))];
        covered += (points[i] - nearest).norm() <= within * measure_spacing_at(nearest, search);
    }
    return double(covered) / double(asked);
}

/// None unless they are nearly all.
Viewpoints take(const std::vector<Scan>& scans, const DistinctRun& run)
{
    if (scans.empty())
        return {};
    Points places, seen;
    std::vector<int> from;
    for (const auto& scan : scans)
    {
        places.push_back(run.middle + scan.place);
        for (std::size_t i = scan.begin; i < scan.end; i += run.points.size() / most_marks + 1)
        {
            seen.push_back(run.points[i]);
            from.push_back(int(places.size()) - 1);
        }
    }
    if (measure_cover(run.points, scans, seen) < nearly_all)
        return {};
    if (places.size() == 1)
        return Viewpoints(places[0]);
    for (Point& p : seen)
        p += run.middle;
    return {std::move(places), std::move(seen), std::move(from)};
}

bool is_near_origin(const Point& place, const Points& points)
{
    std::vector<double> ranges;
    for (std::size_t i = 0; i < points.size(); i += points.size() / most_measured + 1)
        ranges.push_back(points[i].norm());
    return place.norm() < beside_origin * median(std::move(ranges));
}

/// Of which there are the most copies. None if they are few.
std::optional<Point> find_most_copied(Points points)
{
    std::sort(points.begin(), points.end(),
              [](const Point& a, const Point& b)
              { return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3); });
    std::optional<Point> result;
    std::size_t most = fewest_copies - 1;
    for (std::size_t begin = 0, end = 0; begin < points.size(); begin = end)
    {
        while (end < points.size() && points[end] == points[begin])
            ++end;
        if (end - begin > most)
        {
            most = end - begin;
            result = points[begin];
        }
    }
    return result;
}

/// A ray that nothing answered is a reading of range 0, the scanner's own place, wherever the cloud was moved to.
/// \param sorted the points, from which it is told whether they were seen from there.
std::optional<Point> find_place_of_no_reading(const Points& points, const Points& sorted)
{
    const std::optional<Point> place = find_most_copied(points);
    if (!place)
        return {};
    Points from_there;
    for (const Point& p : sorted)
        from_there.push_back(p - *place);
    return is_scanner_at_origin(from_there) ? place : std::nullopt;
}

} // namespace

struct Viewpoints::Seen
{
    Seen(Points seen, std::vector<int> seen_from) : points(std::move(seen)), from(std::move(seen_from)), search(points)
    {
    }
    const Points points;
    const std::vector<int> from;
    const NeighbourSearch search; ///< Of the points.
};

Viewpoints::Viewpoints(Points places, Points seen, std::vector<int> seen_from)
    : places_(std::move(places)), seen_(std::make_shared<Seen>(std::move(seen), std::move(seen_from)))
{
}

const Point& Viewpoints::of(const Point& p) const
{
    return places_[seen_ ? std::size_t(seen_->from[std::size_t(seen_->search.nearest(p))]) : 0];
}

Viewpoints Viewpoints::in(const UnitFrame& frame) const
{
    Viewpoints result;
    for (const Point& place : places_)
        result.places_.push_back(frame.to_unit(place));
    if (seen_)
        result.seen_ = std::make_shared<Seen>(frame.to_unit(seen_->points), seen_->from);
    return result;
}

std::optional<Point> find_scan_origin(const Points& points)
{
    const DistinctRun run(points);
    std::optional<Point> origin = choose_place(run.points, find_gaps(run.points));
    if (origin)
        *origin += run.middle;
    return origin;
}

Viewpoints find_scan_origins(const Points& points, int threads, const Progress& progress)
{
    const DistinctRun run(points);
    std::vector<std::size_t> gaps = find_gaps(run.points);
    const Viewpoints found = take(split_scans(run.points, gaps, threads, progress), run);
    if (found.places().size() < 2)
        if (const std::optional<Point> place = choose_place(run.points, std::move(gaps)))
            return Viewpoints(run.middle + *place);
    return found;
}

Viewpoints find_viewpoints(const Points& points, const Points& sorted, int threads, const Progress& progress)
{
    if (const auto camera = find_depth_camera(sorted))
        return Viewpoints(camera->place);
    Viewpoints in_order = find_scan_origins(points, threads, progress);
    const bool may_be_origin =
        in_order.empty() || (in_order.places().size() == 1 && is_near_origin(in_order.places()[0], sorted));
    if (may_be_origin && is_scanner_at_origin(sorted))
        return Viewpoints(Point::Zero());
    if (in_order.empty())
        if (const std::optional<Point> place = find_place_of_no_reading(points, sorted))
            return Viewpoints(*place);
    return in_order;
}

Viewpoints find_viewpoints(const Points& points, int threads, const Progress& progress)
{
    return find_viewpoints(points, points, threads, progress);
}

} // namespace recon
