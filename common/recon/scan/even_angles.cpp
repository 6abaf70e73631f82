#include <recon/scan/even_angles.h>

#include <recon/median.h>
#include <recon/scramble.h>
#include <recon/search/neighbours.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace recon
{
namespace
{

/// Fewer say nothing [count].
constexpr std::size_t fewest = 100;
/// Bundles of rays that are looked at, points in each, and those of them that are asked [count].
constexpr std::size_t bundles = 16, most_in_bundle = 4'000, most_asked = 2'000;
/// Share of points whose nearest in the image is as far as the median, within a quarter: 0.83 to 1 of sixteen real
/// sweeps, 0.67 where rays leave a scanner as far from its middle as a tenth of the ranges, or of a simulated one that
/// sees 60 degrees up and down, towards whose axis they come together. Of 430 models four have more, a ball 0.92.
constexpr double mostly = 0.65, even = 0.25;
/// Of so many in the image some lie behind a gap if, in order of range, one is so much farther than the one before it
/// and at least so many lie on either side, lest those that stray count; and fewest points around which that is so.
/// Even models have none.
constexpr int around = 24, least_beside = 6;
constexpr double gap = 1.25;
constexpr std::size_t fewest_gaps = 20;

/// Those points that from the origin lie next to the k-th of some random ones.
Points list_bundle(const Points& points, std::size_t k)
{
    struct Ray
    {
        double cosine;
        std::size_t point;
    };
    constexpr double nowhere = -2;
    std::vector<Ray> rays(points.size());
    const Vector ahead = points[scramble(k) % points.size()].normalized();
    for (std::size_t i = 0; i < points.size(); ++i)
    {
        const double cosine = points[i].dot(ahead) / points[i].norm();
        rays[i] = {cosine >= -1 ? cosine : nowhere, i}; // none at the origin
    }
    const auto end = rays.begin() + std::ptrdiff_t(std::min(points.size(), most_in_bundle));
    std::nth_element(rays.begin(), end - 1, rays.end(),
                     [](const Ray& a, const Ray& b)
                     { return a.cosine > b.cosine || (a.cosine == b.cosine && a.point < b.point); });
    Points bundle;
    for (auto ray = rays.begin(); ray != end; ++ray)
        if (ray->cosine > nowhere)
            bundle.push_back(points[ray->point]);
    return bundle;
}

/// How points lie in the image that is seen from the origin.
struct SeenAngles
{
    std::vector<double> steps; ///< To the nearest [radians, nearly].
    std::size_t gaps = 0;      ///< Points with a gap around them [count].

    bool are_even() const
    {
        const double usual = median(steps);
        const auto as_usual = std::count_if(steps.begin(), steps.end(),
                                            [&](double step) { return std::abs(step - usual) <= even * usual; });
        return usual > 0 && double(as_usual) >= mostly * double(steps.size()); // else copies
    }
};

/// \param bundle none at the origin, and as many as are looked at around each.
void look_at(const Points& bundle, SeenAngles& seen)
{
    Points image;
    for (const Point& p : bundle)
        image.push_back(p.normalized());
    const NeighbourSearch search(image);
    for (std::size_t i = 0; i < image.size(); i += image.size() / most_asked + 1)
    {
        std::array<int, around> near;
        std::array<double, around> squared, ranges;
        search.nearest(image[i], around, near.data(), squared.data());
        seen.steps.push_back(std::sqrt(squared[1]));
        std::transform(near.begin(), near.end(), ranges.begin(), [&](int k) { return bundle[std::size_t(k)].norm(); });
        std::sort(ranges.begin(), ranges.end());
        seen.gaps +=
            std::adjacent_find(ranges.begin() + least_beside - 1, ranges.end() - least_beside + 1,
                               [](double a, double b) { return b > gap * a; }) != ranges.end() - least_beside + 1;
    }
}

} // namespace

bool is_scanner_at_origin(const Points& points)
{
    if (points.size() < fewest)
        return false;
    SeenAngles seen;
    for (std::size_t k = 0; k < bundles; ++k)
    {
        const Points bundle = list_bundle(points, k);
        if (bundle.size() < fewest) // nearly all are at the origin
            return false;
        look_at(bundle, seen);
        if (!seen.are_even())
            return false;
    }
    return seen.gaps >= fewest_gaps;
}

} // namespace recon
